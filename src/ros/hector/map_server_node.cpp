// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/hector/map_server_node.h"

#include <ros/console.h>

#include "kestrel_slam/map/obstacle_ray.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/ros/common/guarded.h"

namespace kestrel {
namespace {

constexpr double kLongestWait = 1.0, kWaitStep = 0.01;  // s

Eigen::Isometry3d isometryOf(const geometry_msgs::Pose& pose) {
  geometry_msgs::Transform transform;
  transform.translation.x = pose.position.x;
  transform.translation.y = pose.position.y;
  transform.translation.z = pose.position.z;
  transform.rotation = pose.orientation;
  return fromMessage(transform);
}

geometry_msgs::Pose poseMessage(const Eigen::Isometry3d& pose) {
  geometry_msgs::Pose message;
  const Eigen::Quaterniond rotation(pose.linear());
  message.position.x = pose.translation().x();
  message.position.y = pose.translation().y();
  message.position.z = pose.translation().z();
  message.orientation.x = rotation.x();
  message.orientation.y = rotation.y();
  message.orientation.z = rotation.z();
  message.orientation.w = rotation.w();
  return message;
}

}  // namespace

std::vector<Parameter> parametersOf(MapServerConfig&) { return {}; }

MapServerNode::MapServerNode(ros::NodeHandle nh, const ros::NodeHandle&) {
  subscriber_ = subscribeGuarded<nav_msgs::OccupancyGrid>(
      nh, "map", 1,
      [this](const nav_msgs::OccupancyGrid::ConstPtr& message) {
        map_ = fromMessage(*message);
        message_ = message;
      },
      {}, Stamps::kIgnored);
  map_server_ = nh.advertiseService("map", &MapServerNode::map, this);
  distance_server_ =
      nh.advertiseService("get_distance_to_obstacle", &MapServerNode::distance, this);
  search_server_ = nh.advertiseService("get_search_position", &MapServerNode::searchPosition, this);
}

bool MapServerNode::map(nav_msgs::GetMap::Request&, nav_msgs::GetMap::Response& response) {
  if (message_) response.map = *message_;
  return message_ != nullptr;
}

std::optional<Eigen::Isometry3d> MapServerNode::lookup(const std_msgs::Header& header,
                                                       const char* service) {
  if (!message_) {
    ROS_ERROR("%s: there is no map yet on %s.", service, subscriber_.getTopic().c_str());
    return std::nullopt;
  }
  const std::string& map_frame = message_->header.frame_id;
  std::string error;
  // Wall time: the clock of a replay may stand still.
  for (double waited = 0.0; waited < kLongestWait; waited += kWaitStep) {
    error.clear();
    if (buffer_.canTransform(map_frame, header.frame_id, header.stamp, &error)) {
      return fromMessage(
          buffer_.lookupTransform(map_frame, header.frame_id, header.stamp).transform);
    }
    ros::WallDuration(kWaitStep).sleep();
  }
  ROS_ERROR("%s: no transform from '%s' to '%s': %s", service, header.frame_id.c_str(),
            map_frame.c_str(), error.c_str());
  return std::nullopt;
}

bool MapServerNode::distance(kestrel_slam::GetDistanceToObstacle::Request& request,
                             kestrel_slam::GetDistanceToObstacle::Response& response) {
  const auto map_T_frame = lookup(request.point.header, "get_distance_to_obstacle");
  if (!map_T_frame) return false;
  const geometry_msgs::Point& point = request.point.point;
  const Eigen::Vector3d start = map_T_frame->translation();
  const Eigen::Vector3d direction =
      (map_T_frame->linear() * Eigen::Vector3d(point.x, point.y, point.z)).normalized();
  const auto hit = firstObstacle(map_, start.head<2>(), direction.head<2>());
  response.distance = -1.0F;
  if (!hit) return true;
  // The obstacle is a vertical wall: the way to it is longer if the direction is inclined.
  const double way = (*hit - start.head<2>()).norm() / direction.head<2>().norm();
  const Eigen::Vector3d end = start + way * direction;
  response.distance = static_cast<float>(way);
  response.end_point.header.frame_id = message_->header.frame_id;
  response.end_point.header.stamp = request.point.header.stamp;
  response.end_point.point.x = end.x();
  response.end_point.point.y = end.y();
  response.end_point.point.z = end.z();
  return true;
}

bool MapServerNode::searchPosition(kestrel_slam::GetSearchPosition::Request& request,
                                   kestrel_slam::GetSearchPosition::Response& response) {
  const auto map_T_frame = lookup(request.ooi_pose.header, "get_search_position");
  if (!map_T_frame) return false;
  const Eigen::Isometry3d map_T_object = *map_T_frame * isometryOf(request.ooi_pose.pose);
  response.search_pose.header.frame_id = message_->header.frame_id;
  response.search_pose.header.stamp = request.ooi_pose.header.stamp;
  response.search_pose.pose =
      poseMessage(map_T_object * Eigen::Translation3d(-request.distance, 0.0, 0.0));
  return true;
}

}  // namespace kestrel
