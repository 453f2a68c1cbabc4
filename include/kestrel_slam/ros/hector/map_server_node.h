// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/GetMap.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/node_handle.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "kestrel_slam/GetDistanceToObstacle.h"
#include "kestrel_slam/GetSearchPosition.h"
#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// The node has no parameters.
struct MapServerConfig {};
std::vector<Parameter> parametersOf(MapServerConfig& config);

/// Answers questions about the map, with the interface of hector_map_server.
class MapServerNode {
 public:
  MapServerNode(ros::NodeHandle nh, const ros::NodeHandle& private_nh);

 private:
  bool map(nav_msgs::GetMap::Request& request, nav_msgs::GetMap::Response& response);
  bool distance(kestrel_slam::GetDistanceToObstacle::Request& request,
                kestrel_slam::GetDistanceToObstacle::Response& response);
  bool searchPosition(kestrel_slam::GetSearchPosition::Request& request,
                      kestrel_slam::GetSearchPosition::Response& response);
  /// map_T_frame at the stamp. Waits a second of wall time for it.
  std::optional<Eigen::Isometry3d> lookup(const std_msgs::Header& header, const char* service);

  nav_msgs::OccupancyGrid::ConstPtr message_;
  MapSnapshot map_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_{buffer_};
  ros::Subscriber subscriber_;
  ros::ServiceServer map_server_, distance_server_, search_server_;
};

}  // namespace kestrel
