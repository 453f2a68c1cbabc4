// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/messages/sensor_messages.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include "kestrel_slam/sensor/point_buffer.h"
#include "kestrel_slam/sensor/point_times.h"

namespace kestrel {
namespace {

/// sensor_msgs/Imu: a covariance that begins with -1 marks a value as missing.
template <typename Covariance>
bool exists(const Covariance& covariance) {
  constexpr double kMissing = -1.0;
  return covariance[0] != kMissing;
}

/// Copies the fields that LaserScan and MultiEchoLaserScan have in common.
template <typename Message>
LaserScan withoutRanges(const Message& message) {
  LaserScan scan;
  scan.frame = withoutSlash(message.header.frame_id);
  scan.stamp = toSeconds(message.header.stamp);
  scan.angle_min = static_cast<double>(message.angle_min);
  scan.angle_increment = static_cast<double>(message.angle_increment);
  scan.time_increment = static_cast<double>(message.time_increment);
  scan.range_min = static_cast<double>(message.range_min);
  scan.range_max = static_cast<double>(message.range_max);
  return scan;
}

/// The range of the strongest echo; of the last echo if there is not one intensity for each echo.
float bestEcho(const std::vector<float>& ranges, const std::vector<float>& intensities) {
  if (ranges.empty()) return std::numeric_limits<float>::quiet_NaN();
  if (intensities.size() != ranges.size()) return ranges.back();
  // Searched from the end: of equal intensities (some drivers send zeros), the last one counts.
  const auto strongest = std::max_element(intensities.rbegin(), intensities.rend());
  return ranges[static_cast<std::size_t>(intensities.rend() - strongest) - 1];
}

Eigen::Vector3d toVector(const geometry_msgs::Vector3& v) { return {v.x, v.y, v.z}; }

}  // namespace

double toSeconds(const ros::Time& time) {
  // Converts through text, because sec + 1e-9 * nsec rounds twice. Its last bit can differ from the
  // value in a log file.
  char text[32];
  std::snprintf(text, sizeof text, "%u.%09u", time.sec, time.nsec);
  return std::strtod(text, nullptr);
}

std::string withoutSlash(const std::string& name) {
  return !name.empty() && name.front() == '/' ? name.substr(1) : name;
}

LaserScan fromMessage(const sensor_msgs::LaserScan& message) {
  LaserScan scan = withoutRanges(message);
  scan.ranges = message.ranges;
  return scan;
}

LaserScan fromMessage(const sensor_msgs::MultiEchoLaserScan& message) {
  static const std::vector<float> kNoIntensities;
  LaserScan scan = withoutRanges(message);
  scan.ranges.reserve(message.ranges.size());
  for (std::size_t i = 0; i < message.ranges.size(); ++i) {
    const bool has_intensities = i < message.intensities.size();
    scan.ranges.push_back(bestEcho(message.ranges[i].echoes, has_intensities
                                                                 ? message.intensities[i].echoes
                                                                 : kNoIntensities));
  }
  return scan;
}

PointCloud toPointCloud(const sensor_msgs::PointCloud2& message) {
  PointBuffer buffer;
  for (const sensor_msgs::PointField& field : message.fields) {
    buffer.fields.push_back({field.name, field.offset, field.datatype});
  }
  buffer.width = message.width;
  buffer.height = message.height;
  buffer.point_step = message.point_step;
  buffer.row_step = message.row_step;
  buffer.big_endian = message.is_bigendian != 0;
  buffer.data = message.data.data();
  buffer.size = message.data.size();
  PointCloud cloud = unpackPoints(buffer, toSeconds(message.header.stamp));
  cloud.frame = withoutSlash(message.header.frame_id);
  return cloud;
}

PointCloud toPointCloud(const sensor_msgs::PointCloud& message) {
  if (message.points.empty()) throw std::invalid_argument("the cloud has zero points");
  PointCloud cloud;
  cloud.frame = withoutSlash(message.header.frame_id);
  cloud.stamp = toSeconds(message.header.stamp);
  cloud.points.reserve(message.points.size());
  for (const geometry_msgs::Point32& point : message.points) {
    cloud.points.push_back({point.x, point.y, point.z, 0.0F});
  }
  for (const sensor_msgs::ChannelFloat32& channel : message.channels) {
    if (!isPointTime(channel.name) || channel.values.size() != cloud.points.size()) continue;
    setPointTimes({channel.values.begin(), channel.values.end()}, 1.0, cloud);
    break;
  }
  return cloud;
}

ImuSample toImuSample(const sensor_msgs::Imu& message) {
  ImuSample sample;
  sample.stamp = toSeconds(message.header.stamp);
  const auto& q = message.orientation;
  const bool filled = q.x != 0.0 || q.y != 0.0 || q.z != 0.0 || q.w != 0.0;
  if (exists(message.orientation_covariance) && filled) {
    sample.world_R_imu = Eigen::Quaterniond(q.w, q.x, q.y, q.z);
  }
  if (exists(message.angular_velocity_covariance)) {
    sample.angular_velocity = toVector(message.angular_velocity);
  }
  if (exists(message.linear_acceleration_covariance)) {
    sample.linear_acceleration = toVector(message.linear_acceleration);
  }
  return sample;
}

HeightSample toHeightSample(const sensor_msgs::Range& message, double sensor_z) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double range = message.range;
  const bool limited = message.min_range < message.max_range;
  if (limited && message.range > message.max_range) range = kInfinity;
  if (limited && message.range < message.min_range) range = -kInfinity;
  return {toSeconds(message.header.stamp), range - sensor_z};
}

}  // namespace kestrel
