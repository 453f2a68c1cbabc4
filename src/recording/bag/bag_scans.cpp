// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_scans.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace kestrel {
namespace {

double stampOf(const LaserScan& scan) { return scan.stamp; }
double stampOf(const PointCloud& cloud) { return cloud.stamp; }

void storeSweep(LaserScan scan, BagScan& result) { result.scan = std::move(scan); }
void storeSweep(PointCloud cloud, BagScan& result) { result.cloud = std::move(cloud); }

}  // namespace

BagScans::BagScans(const BagFiles& files, const std::string& topic)
    : topic_(topic), messages_(files, {topic}) {}

bool BagScans::next(BagScan& scan) {
  while (ready_.empty() && !at_end_) {
    if (const rosbag::MessageInstance* message = messages_.next()) {
      read(*message);
    } else {
      finish();
    }
  }
  if (ready_.empty()) return false;
  scan = std::move(ready_.front());
  ready_.pop_front();
  return true;
}

void BagScans::read(const rosbag::MessageInstance& message) {
  ++read_;
  try {
    add(readBagScan(message));
  } catch (const std::invalid_argument& error) {
    skip("unusable cloud", "a message on " + topic_ + " cannot be used: " + error.what());
  } catch (const std::exception& error) {
    messages_.noteFailure();
    skip("broken message",
         "a message on " + topic_ + " is damaged and was skipped: " + error.what());
  }
}

void BagScans::add(BagScan scan) {
  Frame& frame = frames_[scan.frame];
  LaserScan sweep = std::move(scan.scan);
  std::optional<PointCloud> cloud = std::exchange(scan.cloud, std::nullopt);
  scan.scan = LaserScan();
  scan.scan.stamp = sweep.stamp;
  frame.remember(std::move(scan));
  if (cloud) {
    release(frame, frame.clouds.add(std::move(*cloud)));
  } else {
    release(frame, frame.scans.add(std::move(sweep)));
  }
}

/// Gives the sweeps the frame and the exact time of the message with the same stamp.
template <typename Sweeps>
void BagScans::release(Frame& frame, Sweeps sweeps) {
  for (auto& sweep : sweeps) {
    const auto message = frame.messages.find(stampOf(sweep));
    if (message == frame.messages.end()) continue;  // cannot happen: the newest are kept
    ready_.push_back(message->second);
    storeSweep(std::move(sweep), ready_.back());
  }
}

void BagScans::finish() {
  at_end_ = true;
  std::size_t incomplete = 0;
  for (auto& [name, frame] : frames_) {
    release(frame, frame.scans.finish());
    release(frame, frame.clouds.finish());
    incomplete += frame.scans.incomplete() + frame.clouds.incomplete();
  }
  if (messages_.lost() > 0) {
    skip("damaged chunk", "", messages_.lost());
  }
  if (incomplete > 0) {
    skip("incomplete turn", "the last turn on " + topic_ + " is not complete and was left out",
         incomplete);
  }
}

bool BagScans::joins() const {
  return std::any_of(frames_.begin(), frames_.end(), [](const auto& entry) {
    return entry.second.scans.joins() || entry.second.clouds.joins();
  });
}

void BagScans::skip(const std::string& reason, const std::string& warning, std::size_t count) {
  if (on_skip) on_skip(reason, warning, count);
}

/// Keeps more messages than one turn has.
void BagScans::Frame::remember(BagScan message) {
  constexpr std::size_t kEnough = 4000;
  const double stamp = message.scan.stamp;
  if (messages.emplace(stamp, std::move(message)).second) order.push_back(stamp);
  if (order.size() <= kEnough) return;
  messages.erase(order.front());
  order.pop_front();
}

}  // namespace kestrel
