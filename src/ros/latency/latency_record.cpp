// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/latency/latency_record.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kestrel {
namespace {

using Lock = std::lock_guard<std::mutex>;

constexpr double kMsPerSecond = 1000.0;

ros::Time endOf(const sensor_msgs::LaserScan& scan) {
  const double beams = scan.ranges.empty() ? 0.0 : static_cast<double>(scan.ranges.size() - 1);
  return scan.header.stamp + ros::Duration(beams * static_cast<double>(scan.time_increment));
}

}  // namespace

void LatencyRecord::sent(const LiveMessage& message) {
  const Lock lock(mutex_);
  const ros::WallTime now = ros::WallTime::now();
  if (const auto* scan = std::get_if<sensor_msgs::LaserScanPtr>(&message)) {
    const ros::Time end = endOf(**scan);
    const bool is_complete = !needs_imu_ || end <= imu_until_;
    const ros::WallTime complete = is_complete ? now : ros::WallTime();
    scans_[(*scan)->header.stamp] = {end, now, complete, ros::WallTime()};
  } else if (const auto* imu = std::get_if<sensor_msgs::ImuPtr>(&message)) {
    imu_sent_[(*imu)->header.stamp] = now;
    imu_until_ = std::max(imu_until_, (*imu)->header.stamp);
    for (auto entry = scans_.rbegin(); entry != scans_.rend(); ++entry) {
      if (!entry->second.complete.isZero()) break;
      if (entry->second.end <= imu_until_) entry->second.complete = now;
    }
  }
}

void LatencyRecord::poseReceived(const ros::Time& stamp) {
  const Lock lock(mutex_);
  const auto scan = scans_.find(stamp);
  if (scan != scans_.end() && scan->second.posed.isZero()) {
    scan->second.posed = ros::WallTime::now();
  }
}

void LatencyRecord::stateReceived(const ros::Time& stamp) {
  const Lock lock(mutex_);
  const auto imu = imu_sent_.find(stamp);
  if (imu == imu_sent_.end()) return;
  from_imu_.push_back(kMsPerSecond * (ros::WallTime::now() - imu->second).toSec());
  imu_sent_.erase(imu);
}

std::vector<double> LatencyRecord::fromImu() const {
  const Lock lock(mutex_);
  std::vector<double> result = from_imu_;
  std::sort(result.begin(), result.end());
  return result;
}

std::size_t LatencyRecord::sentScans() const {
  const Lock lock(mutex_);
  return scans_.size();
}

std::size_t LatencyRecord::poses() const { return fromScan().size(); }

std::size_t LatencyRecord::dropped() const {
  const Lock lock(mutex_);
  return static_cast<std::size_t>(
      std::count_if(scans_.begin(), scans_.end(), [](const auto& entry) {
        return entry.second.posed.isZero() && !entry.second.complete.isZero();
      }));
}

std::size_t LatencyRecord::incomplete() const {
  const Lock lock(mutex_);
  return static_cast<std::size_t>(
      std::count_if(scans_.begin(), scans_.end(),
                    [](const auto& entry) { return entry.second.complete.isZero(); }));
}

std::vector<double> LatencyRecord::fromScan() const { return latencies(&Scan::sent); }

std::vector<double> LatencyRecord::fromLastInput() const { return latencies(&Scan::complete); }

std::vector<double> LatencyRecord::latencies(ros::WallTime Scan::*from) const {
  const Lock lock(mutex_);
  std::vector<double> values;
  for (const auto& [stamp, scan] : scans_) {
    if (scan.posed.isZero() || (scan.*from).isZero()) continue;
    values.push_back((scan.posed - scan.*from).toSec() * kMsPerSecond);
  }
  std::sort(values.begin(), values.end());
  return values;
}

double quantile(const std::vector<double>& values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  return values[std::max<std::size_t>(static_cast<std::size_t>(rank), 1) - 1];
}

}  // namespace kestrel
