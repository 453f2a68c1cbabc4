// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/filter/filter_publisher.h"

#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/Range.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <vector>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/pipeline_messages.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 200;

/// Assumed IMU rate while the real rate is unknown, Hz.
constexpr double kTypicalRate = 100.0;

template <typename Array>
void fill(const Eigen::Matrix<double, 6, 6>& covariance, Array& target) {
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(target.data()) = covariance;
}

geometry_msgs::Vector3 vectorOf(const Eigen::Vector3d& v) {
  geometry_msgs::Vector3 message;
  message.x = v.x(), message.y = v.y(), message.z = v.z();
  return message;
}

geometry_msgs::Quaternion quaternionOf(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  geometry_msgs::Quaternion message;
  message.w = q.w(), message.x = q.x(), message.y = q.y(), message.z = q.z();
  return message;
}

geometry_msgs::TransformStamped transformOf(const ros::Time& stamp, const std::string& parent,
                                            const std::string& child, const Pose2& pose, double z) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform = toTransformMessage(pose);
  message.transform.translation.z = z;
  return message;
}

}  // namespace

FilterPublisher::FilterPublisher(ros::NodeHandle nh, const PoseFilterNodeConfig& config)
    : config_(config) {
  motion_publisher_ = nh.advertise<kestrel_slam::FilteredMotion>("filtered_motion", kQueue);
  odometry_publisher_ = nh.advertise<nav_msgs::Odometry>("odom/filtered", kQueue);
  height_publisher_ = nh.advertise<sensor_msgs::Range>("height/filtered", kQueue);
  bias_publisher_ = nh.advertise<sensor_msgs::Imu>("imu/bias", kQueue);
}

void FilterPublisher::publish(const ros::Time& stamp, const FilterOutput& output,
                              double imu_rate_hz) {
  if (!output.map_T_base.matrix().allFinite() || !output.odom_T_base.matrix().allFinite() ||
      !output.velocity.allFinite() || !output.covariance.allFinite()) {
    return;
  }
  publishOdometry(stamp, output, imu_rate_hz);  // first, because a controller waits for it
  publishMotion(stamp, output);
  publishHeight(stamp, output);
  publishTransforms(stamp, output);
  publishBias(stamp, output);
}

void FilterPublisher::publishOdometry(const ros::Time& stamp, const FilterOutput& output,
                                      double imu_rate_hz) {
  nav_msgs::Odometry message;
  message.header.stamp = stamp;
  message.header.frame_id = config_.odom_frame;
  message.child_frame_id = config_.base_frame;
  const Eigen::Vector3d& position = output.odom_T_base.translation();
  message.pose.pose.position.x = position.x();
  message.pose.pose.position.y = position.y();
  message.pose.pose.position.z = position.z();
  message.pose.pose.orientation = quaternionOf(output.odom_T_base.linear());
  fill(poseCovariance(output), message.pose.covariance);
  message.twist.twist.linear = vectorOf(output.velocityInBase());
  message.twist.twist.angular = vectorOf(output.angular_velocity);
  const double rate = imu_rate_hz > 0.0 ? imu_rate_hz : kTypicalRate;
  fill(twistCovariance(output, config_.filter.noise.gyro_noise * std::sqrt(rate)),
       message.twist.covariance);
  odometry_publisher_.publish(message);
}

/// Publishes the message for the scan projector.
void FilterPublisher::publishMotion(const ros::Time& stamp, const FilterOutput& output) {
  if (motion_publisher_.getNumSubscribers() == 0) return;
  // A pointer message is passed to a projector in the same process immediately and without a copy.
  motion_publisher_.publish(boost::make_shared<const kestrel_slam::FilteredMotion>(
      toMessage(motionOf(output), stamp, config_.odom_frame)));
}

/// Publishes the height like a range finder that always points straight down. Only while it is
/// known.
void FilterPublisher::publishHeight(const ros::Time& stamp, const FilterOutput& output) {
  if (!output.givesHeight() || height_publisher_.getNumSubscribers() == 0) return;
  height_publisher_.publish(toRangeMessage(stamp, config_.base_stabilized_frame, output.height(),
                                           config_.filter.height.range_max_m));
}

/// Publishes the biases as an Imu message without orientation, like hector_pose_estimation.
void FilterPublisher::publishBias(const ros::Time& stamp, const FilterOutput& output) {
  if (bias_publisher_.getNumSubscribers() == 0) return;
  sensor_msgs::Imu message;
  message.header.stamp = stamp;
  message.header.frame_id = config_.base_frame;
  message.orientation_covariance[0] = -1.0;
  message.angular_velocity = vectorOf(output.gyro_bias);
  message.linear_acceleration = vectorOf(output.accelerometer_bias);
  using Block = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  Block(message.angular_velocity_covariance.data()) =
      output.covariance.block<3, 3>(kGyroBias, kGyroBias);
  Block(message.linear_acceleration_covariance.data()) =
      output.covariance.block<3, 3>(kAccelerometerBias, kAccelerometerBias);
  bias_publisher_.publish(message);
}

void FilterPublisher::publishTransforms(const ros::Time& stamp, const FilterOutput& output) {
  std::vector<geometry_msgs::TransformStamped> transforms;
  if (config_.pub_map_odom_transform) {
    transforms.push_back(transformOf(stamp, config_.map_frame, config_.odom_frame,
                                     toPose2(output.map_T_odom),
                                     output.map_T_odom.translation().z()));
  }
  if (config_.pub_odom_base_transform) {
    // The footprint is on the floor of the map. The projector publishes the frames above it.
    transforms.push_back(transformOf(stamp, config_.odom_frame, config_.base_footprint_frame,
                                     output.odomPose(), -output.map_T_odom.translation().z()));
  }
  if (!transforms.empty()) broadcaster_.sendTransform(transforms);
}

}  // namespace kestrel
