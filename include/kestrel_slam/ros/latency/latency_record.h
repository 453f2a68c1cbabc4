// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>

#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "kestrel_slam/ros/latency/live_player.h"

namespace kestrel {

/// When scans were sent, when their last missing input was, and when their poses came. Every method
/// may be called from any thread.
class LatencyRecord {
 public:
  /// `needs_imu`: the recording has one.
  explicit LatencyRecord(bool needs_imu) : needs_imu_(needs_imu) {}

  void sent(const LiveMessage& message);
  void poseReceived(const ros::Time& stamp);
  void stateReceived(const ros::Time& stamp);  ///< of the pose filter

  std::size_t sentScans() const;
  std::size_t poses() const;
  /// Scans that got no pose although everything that it needs was sent.
  std::size_t dropped() const;
  /// Scans at the end of the recording, with beams newer than its last IMU message.
  std::size_t incomplete() const;
  /// From the publication of a scan to its pose, ms, ascending.
  std::vector<double> fromScan() const;
  /// From the publication of all that a pose needs, which is the scan and an IMU message that is
  /// not older than its last beam, to the pose, ms, ascending.
  std::vector<double> fromLastInput() const;
  /// From the publication of an IMU message to the pose filter's state, ms, ascending.
  std::vector<double> fromImu() const;

 private:
  struct Scan {
    ros::Time end;  ///< of the sweep
    ros::WallTime sent;
    ros::WallTime complete;  ///< zero: the IMU has not come so far yet
    ros::WallTime posed;     ///< zero: no pose yet
  };

  std::vector<double> latencies(ros::WallTime Scan::*from) const;

  const bool needs_imu_;
  mutable std::mutex mutex_;
  std::map<ros::Time, Scan> scans_;              ///< by stamp
  std::map<ros::Time, ros::WallTime> imu_sent_;  ///< those without a state yet
  std::vector<double> from_imu_;                 ///< ms
  ros::Time imu_until_;
};

/// The value below which `share` of the ascending values lie; NaN where there are none.
double quantile(const std::vector<double>& values, double share);

}  // namespace kestrel
