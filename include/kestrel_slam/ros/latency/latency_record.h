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

/// Records when each scan was sent, when its last needed input was sent, and when its pose arrived.
/// Thread-safe.
class LatencyRecord {
 public:
  /// `needs_imu`: true if the recording has an IMU.
  explicit LatencyRecord(bool needs_imu) : needs_imu_(needs_imu) {}

  void sent(const LiveMessage& message);
  void poseReceived(const ros::Time& stamp);
  void stateReceived(const ros::Time& stamp);  ///< of the pose filter

  std::size_t sentScans() const;
  std::size_t poses() const;
  /// Scans without a pose although all needed inputs were sent.
  std::size_t dropped() const;
  /// Scans at the end of the recording, with beams newer than its last IMU message.
  std::size_t incomplete() const;
  /// Latencies from the publication of a scan to its pose, ms, ascending.
  std::vector<double> fromScan() const;
  /// Latencies from the last needed input of a pose to the pose, ms, ascending. The needed inputs
  /// are the scan and an IMU message that is not older than its last beam.
  std::vector<double> fromLastInput() const;
  /// Latencies from the publication of an IMU message to the state of the pose filter, ms,
  /// ascending.
  std::vector<double> fromImu() const;

 private:
  struct Scan {
    ros::Time end;  ///< of the sweep
    ros::WallTime sent;
    ros::WallTime complete;  ///< zero: the needed IMU message was not sent yet
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

/// The quantile `share` of ascending values; NaN if there are no values.
double quantile(const std::vector<double>& values, double share);

}  // namespace kestrel
