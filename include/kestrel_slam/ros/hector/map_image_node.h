// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <nav_msgs/OccupancyGrid.h>
#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <optional>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

struct MapImageConfig {
  int tile_size = 64;  ///< cells
};
std::vector<Parameter> parametersOf(MapImageConfig& config);

/// The part of a map with at most `size` x `size` cells around a pose; at its border, the part that
/// is still inside of the map.
MapSnapshot tileAround(const MapSnapshot& map, const Pose2& pose, int size);

/// The map as a gray image with the gray values of hector_compressed_map_transport: 255 is free,
/// 127 unknown, 0 occupied. The first row has the largest y.
sensor_msgs::Image imageOf(const MapSnapshot& map);

/// Publishes the map as images, raw and as PNG, with the topics of hector_compressed_map_transport.
class MapImageNode {
 public:
  MapImageNode(ros::NodeHandle nh, const ros::NodeHandle& private_nh);

 private:
  struct Outputs {
    ros::Publisher raw, compressed;
  };

  void onMap(const nav_msgs::OccupancyGrid& message);
  static void publish(const Outputs& outputs, const MapSnapshot& map, const ros::Time& stamp);

  MapImageConfig config_;
  std::optional<Pose2> pose_;
  Outputs full_, tile_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace kestrel
