// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/ros/common/silence_watch.h"
#include "kestrel_slam/ros/common/waiting_time.h"
#include "kestrel_slam/ros/projector/projector_statistics.h"
#include "kestrel_slam/sensor/attitude_tracker.h"

namespace kestrel {

/// The state of the scan projector's node, for the diagnostics.
struct ProjectorReport {
  ProjectorStatistics statistics;
  std::string topics;                 ///< of the lasers
  unsigned publishers = 0;            ///< of these topics
  std::string waiting_for;            ///< missing transform of the newest sweep, or empty
  std::string attitude_hint;          ///< the source of the attitude
  std::string attitude_error;         ///< error of the attitude, or empty
  std::vector<std::string> problems;  ///< of the IMU and the mountings, as the pipeline says them
  std::optional<ImuStatus> imu;
  std::string imu_topic;
  unsigned imu_publishers = 0;
  std::optional<double> tilt_rad;  ///< newest
  std::optional<double> height_m;  ///< newest height of the base above the floor
  std::string height_source;
  std::string height_error;  ///< error of the height, or empty
  std::map<std::string, std::size_t> height_counts;
};

/// Publishes /diagnostics of the scan projector: items for the scans, the attitude and the height.
class ProjectorDiagnostics {
 public:
  /// `report` is called once per second on the queue of `nh`, then `on_reported`. `lasers`, `imu`:
  /// the topics that the node needs; `imu` may be empty.
  ProjectorDiagnostics(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh,
                       const std::vector<NeededTopic>& lasers, const std::vector<NeededTopic>& imu,
                       std::function<ProjectorReport()> report, std::function<void()> on_reported);

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;

  void update();
  void checkSilence();
  void warn() const;
  void fillScans(Status& status) const;
  void fillAttitude(Status& status) const;
  void fillImu(Status& status) const;
  void fillHeight(Status& status) const;

  std::function<ProjectorReport()> take_report_;
  std::function<void()> on_reported_;
  SilenceWatch laser_watch_, imu_watch_;
  std::string silence_;      ///< why there are no scans; empty if scans arrive
  std::string imu_silence_;  ///< why no IMU message ever came; empty if one came
  ProjectorReport report_;
  WaitingTime since_start_;
  diagnostic_updater::Updater updater_;
  ros::SteadyTimer timer_;
};

}  // namespace kestrel
