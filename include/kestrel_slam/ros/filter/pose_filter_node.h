// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <geometry_msgs/PointStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/node_handle.h>
#include <ros/steady_timer.h>
#include <sensor_msgs/FluidPressure.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/MagneticField.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/Range.h>
#include <std_srvs/Trigger.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/MapperState.h"
#include "kestrel_slam/filter/pose_filter.h"
#include "kestrel_slam/messages/aiding_messages.h"
#include "kestrel_slam/ros/common/mountings.h"
#include "kestrel_slam/ros/common/range_mounting.h"
#include "kestrel_slam/ros/common/silence_watch.h"
#include "kestrel_slam/ros/common/waiting_time.h"
#include "kestrel_slam/ros/filter/filter_publisher.h"
#include "kestrel_slam/ros/filter/pose_filter_parameters.h"

namespace kestrel {

/// ROS node of the pose filter. Inputs: IMU, poses of the mapper, heights and other sensors.
/// Output: the full state of the vehicle at the IMU rate. All work is done on the thread that
/// serves `nh`.
class PoseFilterNode {
 public:
  /// `nh` must be served by one thread. Throws std::invalid_argument if a parameter is invalid.
  PoseFilterNode(ros::NodeHandle nh, ros::NodeHandle private_nh);
  PoseFilterNode(const PoseFilterNode&) = delete;
  PoseFilterNode& operator=(const PoseFilterNode&) = delete;

 private:
  void listen(ros::NodeHandle& nh);
  template <typename Message>
  void listen(ros::NodeHandle& nh, const std::string& topic,
              void (PoseFilterNode::*callback)(const Message&));
  void onImu(const sensor_msgs::ImuConstPtr& message);
  void onMapperState(const kestrel_slam::MapperState& message);
  void onPose(const geometry_msgs::PoseWithCovarianceStamped& message);
  void onRange(const sensor_msgs::Range& message);
  void onPressure(const sensor_msgs::FluidPressure& message);
  void onPressureHeight(const geometry_msgs::PointStamped& message);
  void onField(const sensor_msgs::MagneticField& message);
  void onFix(const sensor_msgs::NavSatFix& message);
  void onInitialPose(const geometry_msgs::PoseWithCovarianceStamped& message);
  bool reset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  bool isInMap(const std_msgs::Header& header, const char* what);
  void refuse(const std::string& what, const std::string& reason, const std::string& why);
  std::string imuSilence();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);
  double now() const { return last_stamp_ + since_last_.seconds(); }

  const PoseFilterNodeConfig config_;
  PoseFilter filter_;
  Mountings mountings_;
  RangeMounting range_mounting_;
  FilterPublisher publisher_;
  LocalFixes fixes_;
  std::string waiting_for_;                     ///< message about a mounting that is missing in tf
  std::map<std::string, std::size_t> refused_;  ///< messages by reason
  std::string last_refusal_;
  double mapper_stamp_ = 0.0;  ///< of the last MapperState, s
  double last_stamp_ = 0.0;    ///< of the IMU, s
  WaitingTime since_last_;
  WaitingTime since_start_;
  std::unique_ptr<SilenceWatch> imu_watch_;
  std::vector<ros::Subscriber> subscribers_;
  ros::Subscriber imu_subscriber_;
  ros::ServiceServer reset_server_;
  diagnostic_updater::Updater updater_;
  ros::SteadyTimer timer_;
};

}  // namespace kestrel
