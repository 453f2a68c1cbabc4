// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/pose_publisher.h"

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include <boost/make_shared.hpp>
#include <vector>

#include "kestrel_slam/MapperState.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/pipeline_messages.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/ros/common/stamps.h"
#include "kestrel_slam/ros/mapper/uncertainty_markers.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueueSize = 10;

}  // namespace

PosePublisher::PosePublisher(ros::NodeHandle nh, const MapperNodeConfig& config) : config_(config) {
  using geometry_msgs::PoseWithCovarianceStamped;
  state_publisher_ = nh.advertise<kestrel_slam::MapperState>("mapper_state", kQueueSize);
  pose_publisher_ = nh.advertise<geometry_msgs::PoseStamped>("slam_out_pose", kQueueSize);
  pose_update_publisher_ =
      nh.advertise<PoseWithCovarianceStamped>(config.pose_update_topic, kQueueSize);
  cloud_publisher_ = nh.advertise<sensor_msgs::PointCloud2>("slam_cloud", kQueueSize);
  marker_publisher_ =
      nh.advertise<visualization_msgs::MarkerArray>("degeneracy_marker", kQueueSize);
  slam_odometry_publisher_ = nh.advertise<nav_msgs::Odometry>("odom/slam", kQueueSize);
  if (config.pub_odometry) {
    odometry_publisher_ = nh.advertise<nav_msgs::Odometry>("scanmatch_odom", kQueueSize);
  }
}

void PosePublisher::publish(const ros::Time& stamp, const MapperResult& result,
                            const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) {
  // Published first, because the pose filter waits for it.
  state_publisher_.publish(boost::make_shared<const kestrel_slam::MapperState>(
      toMessage(matchedPoseOf(result, toSeconds(stamp)), stamp, config_.map_frame)));
  if (odom_T_base) map_T_odom_ = result.pose * odom_T_base->inverse();
  publishTransforms(stamp, result.pose);
  publishPose(stamp, result);
  publishCloud(stamp, result, scan);
  publishMarkers(stamp, result);
}

void PosePublisher::repeatCorrection(const ros::Time& stamp) {
  if (!map_T_odom_ || !config_.pub_map_odom_transform) return;
  broadcaster_.sendTransform(
      transform(shifted(stamp, config_.transform_tolerance), config_.odom_frame, *map_T_odom_));
}

void PosePublisher::place(const Pose2& map_T_base, const std::optional<Pose2>& odom_T_base) {
  if (odom_T_base) map_T_odom_ = map_T_base * odom_T_base->inverse();
}

std::optional<Pose2> PosePublisher::poseByOdometry(const std::optional<Pose2>& odom_T_base) const {
  if (!map_T_odom_ || !odom_T_base) return std::nullopt;
  return *map_T_odom_ * *odom_T_base;
}

void PosePublisher::publishTransforms(const ros::Time& stamp, const Pose2& map_T_base) {
  // Scans of several lasers may have the same stamp, but tf accepts only one transform per stamp.
  if (stamp == transforms_stamp_) return;
  transforms_stamp_ = stamp;
  std::vector<geometry_msgs::TransformStamped> transforms;
  if (config_.pub_map_odom_transform && !config_.usesOdometry()) {
    // The stamp is not moved into the future, because tf interpolates between stamps and the pose
    // would be late by the tolerance.
    transforms.push_back(transform(stamp, config_.base_frame, map_T_base));
  } else if (config_.pub_map_odom_transform && map_T_odom_) {
    transforms.push_back(
        transform(shifted(stamp, config_.transform_tolerance), config_.odom_frame, *map_T_odom_));
  }
  if (config_.pub_map_scanmatch_transform) {
    transforms.push_back(
        transform(stamp, config_.tf_map_scanmatch_transform_frame_name, map_T_base));
  }
  if (!transforms.empty()) broadcaster_.sendTransform(transforms);
}

geometry_msgs::TransformStamped PosePublisher::transform(const ros::Time& stamp,
                                                         const std::string& child,
                                                         const Pose2& map_T_child) const {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = config_.map_frame;
  message.child_frame_id = child;
  message.transform = toTransformMessage(map_T_child);
  return message;
}

void PosePublisher::publishPose(const ros::Time& stamp, const MapperResult& result) {
  geometry_msgs::PoseWithCovarianceStamped update;
  update.header.stamp = stamp;
  update.header.frame_id = config_.map_frame;
  update.pose = toMessage(result.pose, result.covariance);
  // Its readers take it as a measurement, and a lost pose is only a prediction.
  if (result.state != MatchState::kLost) pose_update_publisher_.publish(update);

  geometry_msgs::PoseStamped pose;
  pose.header = update.header;
  pose.pose = update.pose.pose;
  pose_publisher_.publish(pose);

  nav_msgs::Odometry odometry;
  odometry.header = update.header;
  odometry.child_frame_id = config_.base_frame;
  odometry.pose = update.pose;
  odometry.twist.twist.linear.x = result.velocity.x();
  odometry.twist.twist.linear.y = result.velocity.y();
  slam_odometry_publisher_.publish(boost::make_shared<const nav_msgs::Odometry>(odometry));
  if (config_.pub_odometry) odometry_publisher_.publish(odometry);
}

void PosePublisher::publishCloud(const ros::Time& stamp, const MapperResult& result,
                                 const PlanarScan& scan) {
  if (cloud_publisher_.getNumSubscribers() == 0) return;
  sensor_msgs::PointCloud2 cloud = hitCloud(scan, result.pose);
  cloud.header.stamp = stamp;
  cloud.header.frame_id = config_.map_frame;
  cloud_publisher_.publish(cloud);
}

void PosePublisher::publishMarkers(const ros::Time& stamp, const MapperResult& result) {
  if (marker_publisher_.getNumSubscribers() == 0) return;
  visualization_msgs::MarkerArray markers = uncertaintyMarkers(result);
  for (visualization_msgs::Marker& marker : markers.markers) {
    marker.header.stamp = stamp;
    marker.header.frame_id = config_.map_frame;
  }
  marker_publisher_.publish(markers);
}

}  // namespace kestrel
