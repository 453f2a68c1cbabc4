// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/hector/map_image_node.h"

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <cmath>

#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/report/map_image.h"
#include "kestrel_slam/ros/common/guarded.h"
#include "kestrel_slam/ros/common/private_parameters.h"

namespace kestrel {
namespace {

constexpr const char* kFrame = "map_image";
constexpr MapGrays kGrays = {255, 127, 0};

/// First cell of a window of `size` cells around `position` in a row of `cells`.
int firstOf(double position, int size, int cells) {
  const double first = std::floor(position) - size / 2;
  return static_cast<int>(std::clamp(first, 0.0, static_cast<double>(std::max(0, cells - size))));
}

}  // namespace

std::vector<Parameter> parametersOf(MapImageConfig& config) {
  using namespace parameter_table;
  constexpr double kSmallest = 8, kLargest = 4096;
  return group("Images", {number("tile_size", "cells", &config.tile_size, kSmallest, kLargest,
                                 "Width and height of map_image/tile.")});
}

MapSnapshot tileAround(const MapSnapshot& map, const Pose2& pose, int size) {
  MapSnapshot tile = map;
  const int column = firstOf((pose.x - map.origin_x) / map.resolution_m, size, map.width);
  const int row = firstOf((pose.y - map.origin_y) / map.resolution_m, size, map.height);
  tile.width = std::min(size, map.width);
  tile.height = std::min(size, map.height);
  tile.origin_x += column * map.resolution_m;
  tile.origin_y += row * map.resolution_m;
  tile.cells.clear();
  for (int y = row; y < row + tile.height; ++y) {
    for (int x = column; x < column + tile.width; ++x) tile.cells.push_back(map.at(x, y));
  }
  return tile;
}

sensor_msgs::Image imageOf(const MapSnapshot& map) {
  sensor_msgs::Image image;
  image.width = static_cast<std::uint32_t>(map.width);
  image.height = static_cast<std::uint32_t>(map.height);
  image.step = image.width;
  image.encoding = sensor_msgs::image_encodings::MONO8;
  image.data.reserve(map.cells.size());
  for (int row = map.height - 1; row >= 0; --row) {
    for (int column = 0; column < map.width; ++column) {
      image.data.push_back(grayOf(map.at(column, row), kGrays));
    }
  }
  return image;
}

MapImageNode::MapImageNode(ros::NodeHandle nh, const ros::NodeHandle& private_nh) {
  readPrivateParameters(private_nh, parametersOf(config_), {});
  for (auto& [outputs, name] : {std::pair{&full_, "map_image/full"}, {&tile_, "map_image/tile"}}) {
    outputs->raw = nh.advertise<sensor_msgs::Image>(name, 1, true);
    outputs->compressed =
        nh.advertise<sensor_msgs::CompressedImage>(std::string(name) + "/compressed", 1, true);
  }
  subscribers_.push_back(subscribeGuarded<nav_msgs::OccupancyGrid>(
      nh, "map", 1, [this](const nav_msgs::OccupancyGrid::ConstPtr& map) { onMap(*map); }, {},
      Stamps::kIgnored));
  // hector_compressed_map_transport reads `pose`, which launch files remap; the mapper has another
  // name.
  for (const char* topic : {"pose", "slam_out_pose"}) {
    subscribers_.push_back(subscribeGuarded<geometry_msgs::PoseStamped>(
        nh, topic, 1, [this](const geometry_msgs::PoseStamped::ConstPtr& pose) {
          pose_ = planarFromMessage(pose->pose);
        }));
  }
}

void MapImageNode::onMap(const nav_msgs::OccupancyGrid& message) {
  const MapSnapshot map = fromMessage(message);
  if (map.empty()) return;
  publish(full_, map, message.header.stamp);
  if (pose_) publish(tile_, tileAround(map, *pose_, config_.tile_size), message.header.stamp);
}

void MapImageNode::publish(const Outputs& outputs, const MapSnapshot& map, const ros::Time& stamp) {
  if (outputs.raw.getNumSubscribers() > 0) {
    sensor_msgs::Image image = imageOf(map);
    image.header.frame_id = kFrame;
    image.header.stamp = stamp;
    outputs.raw.publish(image);
  }
  if (outputs.compressed.getNumSubscribers() > 0) {
    sensor_msgs::CompressedImage image;
    image.header.frame_id = kFrame;
    image.header.stamp = stamp;
    image.format = "mono8; png compressed mono8";
    const std::string png = renderMap(map, std::max(map.width, map.height), kGrays).png;
    image.data.assign(png.begin(), png.end());
    outputs.compressed.publish(image);
  }
}

}  // namespace kestrel
