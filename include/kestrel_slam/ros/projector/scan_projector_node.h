// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <ros/steady_timer.h>

#include <memory>
#include <string>

#include "kestrel_slam/ros/common/mountings.h"
#include "kestrel_slam/ros/projector/attitude_publisher.h"
#include "kestrel_slam/ros/projector/filter_input.h"
#include "kestrel_slam/ros/projector/height_input.h"
#include "kestrel_slam/ros/projector/imu_input.h"
#include "kestrel_slam/ros/projector/planar_scan_publisher.h"
#include "kestrel_slam/ros/projector/projector_diagnostics.h"
#include "kestrel_slam/ros/projector/projector_parameters.h"
#include "kestrel_slam/ros/projector/projector_statistics.h"
#include "kestrel_slam/ros/projector/sweep_input.h"
#include "kestrel_slam/ros/projector/sweep_queue.h"
#include "kestrel_slam/ros/projector/tf_attitude.h"
#include "kestrel_slam/ros/projector/velocity_input.h"
#include "kestrel_slam/sensor/attitude_tracker.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {

/// The scan projector, live: sweeps of lasers, IMU and height in; planar scans and tf out.
///
/// Every sweep waits in a queue until the attitude is known up to its last beam, but not for longer
/// than max_wait. All work is done on the thread that serves `nh`.
class ScanProjectorNode {
 public:
  /// `nh` must be served by one thread. Throws std::invalid_argument on a bad parameter.
  ScanProjectorNode(ros::NodeHandle nh, ros::NodeHandle private_nh);
  ScanProjectorNode(const ScanProjectorNode&) = delete;
  ScanProjectorNode& operator=(const ScanProjectorNode&) = delete;

 private:
  /// What is to be done with a sweep now.
  struct Verdict {
    enum Kind { kProject, kProjectLevel, kWait, kDrop } kind;
    std::string reason, sentence;  ///< of kDrop
  };

  void enqueue(Sweep sweep);
  void processQueue();
  bool handle(const Sweep& sweep);
  bool waitsForFilter(const Sweep& sweep) const;
  Verdict judge(const Sweep& sweep);
  Verdict judgeTfAttitude(const Sweep& sweep);
  Verdict judgeImuAttitude(const Sweep& sweep) const;
  std::string uncovered(const Sweep& sweep) const;
  void project(const Sweep& sweep, const Eigen::Isometry3d& base_T_laser, bool is_level);
  void drop(const Sweep& sweep, const std::string& reason, const std::string& sentence);
  void onAttitude(const ros::Time& stamp);
  void publishAttitude(const ros::Time& stamp, const AttitudeBuffer* attitudes);
  ProjectorReport report() const;
  void describeAttitude(ProjectorReport& report) const;

  const ProjectorNodeConfig config_;
  ScanProjector projector_;
  ProjectorStatistics statistics_;
  SweepQueue queue_;
  AttitudeTracker tracker_;
  Mountings mountings_;
  std::string waiting_for_;  ///< a mounting that tf lacks
  std::string tf_error_;     ///< an attitude that tf lacks

  TfAttitude tf_attitude_;
  FilterInput filter_;
  const AttitudeBuffer* last_attitude_ = nullptr;  ///< of the sweep before, if any
  HeightInput height_;
  VelocityInput velocity_;
  PlanarScanPublisher scan_publisher_;
  AttitudePublisher attitude_publisher_;
  std::unique_ptr<ImuInput> imu_;  ///< null where the attitude is not that of an IMU
  std::unique_ptr<SweepInput> input_;
  std::unique_ptr<ProjectorDiagnostics> diagnostics_;
  ros::SteadyTimer timer_;
};

}  // namespace kestrel
