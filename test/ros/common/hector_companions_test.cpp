// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/ros/hector/map_image_node.h"
#include "kestrel_slam/ros/mapper/trajectory_services.h"

namespace kestrel {
namespace {

/// Along x with 1 m/s, a pose per second.
nav_msgs::Path straightPath(int poses) {
  nav_msgs::Path path;
  for (int i = 0; i < poses; ++i) {
    geometry_msgs::PoseStamped pose;
    pose.header.stamp = ros::Time(100.0 + i);
    pose.pose = toMessage(Pose2(i, 0.0, 0.0));
    path.poses.push_back(pose);
  }
  return path;
}

TEST(WayBackTest, EndsWhereTheVehicleEnteredTheRadius) {
  const auto found = wayBack(straightPath(10), ros::Time(106.5), 2.5);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->req_pose.pose.position.x, 7.0);
  EXPECT_EQ(found->radius_entry_pose.pose.position.x, 4.0);
  const auto& way = found->trajectory_radius_entry_pose_to_req_pose.poses;
  ASSERT_EQ(way.size(), 4U);
  EXPECT_EQ(way.front().pose.position.x, 7.0);
  EXPECT_EQ(way.back().pose.position.x, 4.0);
}

TEST(WayBackTest, ALateTimeMeansTheLastPose) {
  EXPECT_EQ(wayBack(straightPath(10), ros::Time(500.0), 1.0)->req_pose.pose.position.x, 9.0);
}

TEST(WayBackTest, ThereMayBeNone) {
  EXPECT_FALSE(wayBack(straightPath(10), ros::Time(105.0), 6.0));
  EXPECT_FALSE(wayBack(straightPath(0), ros::Time(105.0), 1.0));
}

/// The value of a cell is that of its column.
MapSnapshot columns(int width, int height) {
  MapSnapshot map;
  map.resolution_m = 0.5;
  map.width = width;
  map.height = height;
  for (int i = 0; i < width * height; ++i) {
    map.cells.push_back(i % width == 0 ? MapSnapshot::kOccupied : MapSnapshot::kFree);
  }
  return map;
}

TEST(MapImageTest, TheTileStaysInTheMap) {
  const MapSnapshot map = columns(20, 10);
  const MapSnapshot middle = tileAround(map, Pose2(5.0, 2.5, 0.0), 4);
  EXPECT_EQ(middle.width, 4);
  EXPECT_EQ(middle.height, 4);
  EXPECT_EQ(middle.origin_x, 4.0);
  EXPECT_EQ(middle.origin_y, 1.5);
  EXPECT_EQ(middle.at(0, 0), MapSnapshot::kFree);
  const MapSnapshot corner = tileAround(map, Pose2(-50.0, 50.0, 0.0), 4);
  EXPECT_EQ(corner.origin_x, 0.0);
  EXPECT_EQ(corner.origin_y, 3.0);
  EXPECT_EQ(corner.at(0, 0), MapSnapshot::kOccupied);
  const MapSnapshot whole = tileAround(map, Pose2(), 64);
  EXPECT_EQ(whole.width, 20);
  EXPECT_EQ(whole.cells, map.cells);
}

TEST(MapImageTest, HasTheGrayValuesOfHector) {
  MapSnapshot map = columns(3, 2);
  map.cells = {MapSnapshot::kFree,    MapSnapshot::kFree,     MapSnapshot::kFree,
               MapSnapshot::kUnknown, MapSnapshot::kOccupied, MapSnapshot::kFree};
  const sensor_msgs::Image image = imageOf(map);
  EXPECT_EQ(image.encoding, "mono8");
  EXPECT_EQ(image.data, (std::vector<std::uint8_t>{127, 0, 255, 255, 255, 255}));
}

TEST(MapMessageTest, SurvivesTheWayThroughAMessage) {
  MapSnapshot map = columns(3, 2);
  map.resolution_m = 0.05;
  map.cells[1] = MapSnapshot::kUnknown;
  const MapSnapshot back = fromMessage(toMessage(map));
  EXPECT_EQ(back.resolution_m, 0.05);
  EXPECT_EQ(back.cells, map.cells);
  nav_msgs::OccupancyGrid broken = toMessage(map);
  broken.data.pop_back();
  EXPECT_TRUE(fromMessage(broken).empty());
}

}  // namespace
}  // namespace kestrel
