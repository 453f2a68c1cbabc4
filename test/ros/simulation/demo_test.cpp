// SPDX-License-Identifier: BSD-3-Clause
#include <geometry_msgs/PoseStamped.h>
#include <gtest/gtest.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>

#include <cmath>
#include <map>

#include "patience.h"

namespace {

/// demo.launch without rviz: the map grows, and the pose follows the truth.
TEST(Demo, TheSimulatedQuadrotorIsMapped) {
  ros::NodeHandle nh;
  geometry_msgs::PoseStamped first, pose;
  nav_msgs::OccupancyGrid map;
  std::map<ros::Time, nav_msgs::Odometry> truth;
  std::size_t poses = 0;
  const auto a = nh.subscribe<geometry_msgs::PoseStamped>(
      "slam_out_pose", 100, [&](const geometry_msgs::PoseStamped::ConstPtr& message) {
        pose = *message;
        if (poses++ == 0) first = *message;
      });
  const auto b = nh.subscribe<nav_msgs::OccupancyGrid>(
      "map", 1, [&](const nav_msgs::OccupancyGrid::ConstPtr& message) { map = *message; });
  const auto c = nh.subscribe<nav_msgs::Odometry>("ground_truth", 1000,
                                                  [&](const nav_msgs::Odometry::ConstPtr& message) {
                                                    truth[message->header.stamp] = *message;
                                                  });
  kestrel::Patience patience;
  while (!patience.isOver() && (poses < 300 || map.data.empty())) {
    ros::spinOnce();
    ros::WallDuration(0.01).sleep();
  }
  ASSERT_GE(poses, 300U);
  ASSERT_FALSE(map.data.empty());
  ASSERT_FALSE(truth.empty());
  // The map begins where the first scan was matched, so distances are compared.
  const auto begin = truth.lower_bound(first.header.stamp);
  const auto last = truth.lower_bound(pose.header.stamp);
  ASSERT_NE(begin, truth.end());
  ASSERT_NE(last, truth.end());
  const auto &p0 = first.pose.position, &p1 = pose.pose.position;
  const auto& t0 = begin->second.pose.pose.position;
  const auto& t1 = last->second.pose.pose.position;
  EXPECT_NEAR(std::hypot(p1.x - p0.x, p1.y - p0.y), std::hypot(t1.x - t0.x, t1.y - t0.y), 0.1);
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "demo_test");
  return RUN_ALL_TESTS();
}
