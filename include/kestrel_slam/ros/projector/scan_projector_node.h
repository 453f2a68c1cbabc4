// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <ros/steady_timer.h>

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "kestrel_slam/pipeline/projection_stage.h"
#include "kestrel_slam/pipeline/waiting_queue.h"
#include "kestrel_slam/ros/common/live_parameters.h"
#include "kestrel_slam/ros/common/mountings.h"
#include "kestrel_slam/ros/projector/attitude_publisher.h"
#include "kestrel_slam/ros/projector/filter_input.h"
#include "kestrel_slam/ros/projector/height_input.h"
#include "kestrel_slam/ros/projector/imu_input.h"
#include "kestrel_slam/ros/projector/planar_scan_publisher.h"
#include "kestrel_slam/ros/projector/projector_diagnostics.h"
#include "kestrel_slam/ros/projector/projector_parameters.h"
#include "kestrel_slam/ros/projector/projector_statistics.h"
#include "kestrel_slam/ros/projector/sweep.h"
#include "kestrel_slam/ros/projector/sweep_input.h"
#include "kestrel_slam/ros/projector/tf_attitude.h"
#include "kestrel_slam/ros/projector/velocity_input.h"

namespace kestrel {

/// ROS node of the scan projector. Inputs: laser sweeps, IMU and height. Outputs: planar scans and
/// tf.
///
/// Every sweep waits in a queue until the attitude at its last beam is known, but at most for
/// max_wait. All work is done on the thread that serves `nh`.
class ScanProjectorNode {
 public:
  /// `nh` must be served by one thread. Throws std::invalid_argument if a parameter is invalid.
  ScanProjectorNode(ros::NodeHandle nh, ros::NodeHandle private_nh);
  ScanProjectorNode(const ScanProjectorNode&) = delete;
  ScanProjectorNode& operator=(const ScanProjectorNode&) = delete;

 private:
  std::vector<NeededTopic> imuTopics() const;
  void enqueue(Sweep sweep);
  void processQueue();
  bool handle(const Sweep& sweep);
  SweepDecision judge(const Sweep& sweep);
  SweepDecision judgeTfAttitude(const Sweep& sweep);
  void project(const Sweep& sweep, const Eigen::Isometry3d& base_T_laser, bool is_level);
  void drop(const Sweep& sweep, const std::string& reason, const std::string& sentence);
  void onAttitude(const ros::Time& stamp);
  void publishAttitude(const ros::Time& stamp, const AttitudeBuffer* attitudes);
  ProjectorReport report() const;
  void sayProblems();
  void describeAttitude(ProjectorReport& report) const;

  const ProjectorNodeConfig config_;  ///< as at the start
  ProjectorNodeConfig live_config_;   ///< with what was changed since the start
  ProjectionStage projection_;
  ProjectorStatistics statistics_;
  WaitingQueue<Sweep> queue_;
  Mountings mountings_;
  std::string waiting_for_;     ///< message about a mounting that is missing in tf
  std::string tf_error_;        ///< message about an attitude that is missing in tf
  double newest_ = 0.0;         ///< stamp of the newest sweep, s
  std::set<std::string> said_;  ///< reasons of problems of the IMU and the mountings

  TfAttitude tf_attitude_;
  FilterInput filter_;
  HeightInput height_;
  VelocityInput velocity_;
  PlanarScanPublisher scan_publisher_;
  AttitudePublisher attitude_publisher_;
  std::unique_ptr<ImuInput> imu_;  ///< null if the attitude does not come from an IMU
  std::unique_ptr<SweepInput> input_;
  std::unique_ptr<ProjectorDiagnostics> diagnostics_;
  ros::SteadyTimer timer_;
  std::unique_ptr<LiveParameters> live_parameters_;
};

}  // namespace kestrel
