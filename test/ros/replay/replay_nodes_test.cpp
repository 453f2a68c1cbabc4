// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "patience.h"

namespace {

using Edges = std::set<std::string>;

bool waitFor(const std::function<bool()>& done) {
  kestrel::Patience patience;
  while (ros::ok() && !done() && !patience.isOver()) {
    ros::spinOnce();
    ros::WallDuration(0.01).sleep();
  }
  return done();
}

geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child) {
  geometry_msgs::TransformStamped t;
  t.header.frame_id = parent;
  t.child_frame_id = child;
  t.transform.rotation.w = 1.0;
  return t;
}

boost::function<void(const tf2_msgs::TFMessage&)> collect(Edges& edges) {
  return [&edges](const tf2_msgs::TFMessage& message) {
    for (const auto& t : message.transforms) {
      edges.insert(t.header.frame_id + " -> " + t.child_frame_id);
    }
  };
}

TEST(RecordedTransforms, LeavesOutWhatTheNodesPublish) {
  ros::NodeHandle node;
  Edges with_odometry, laser_only, fixed;
  const auto a = node.subscribe<tf2_msgs::TFMessage>("/tf", 10, collect(with_odometry));
  const auto b = node.subscribe<tf2_msgs::TFMessage>("/tf_laser_only", 10, collect(laser_only));
  const auto c = node.subscribe<tf2_msgs::TFMessage>("/tf_static", 10, collect(fixed));
  auto tf = node.advertise<tf2_msgs::TFMessage>("recorded/tf", 10);
  auto tf_static = node.advertise<tf2_msgs::TFMessage>("recorded/tf_static", 10, true);
  ASSERT_TRUE(waitFor([&] {
    return tf.getNumSubscribers() == 2 && tf_static.getNumSubscribers() == 2 &&
           a.getNumPublishers() == 1 && b.getNumPublishers() == 1 && c.getNumPublishers() == 2;
  }));
  tf2_msgs::TFMessage recorded;
  recorded.transforms = {transform("/map", "odom"), transform("odom", "base_link"),
                         transform("base_link", "gimbal"), transform("uav/map", "odom")};
  tf.publish(recorded);
  tf2_msgs::TFMessage mounting;
  mounting.transforms = {transform("base_link", "laser")};
  tf_static.publish(mounting);
  waitFor([&] { return with_odometry.size() >= 2 && laser_only.size() >= 2 && !fixed.empty(); });
  EXPECT_EQ(with_odometry, (Edges{"odom -> base_link", "base_link -> gimbal"}));
  EXPECT_EQ(laser_only, (Edges{"/map -> odom", "base_link -> gimbal", "uav/map -> odom"}));
  EXPECT_EQ(fixed, (Edges{"base_link -> laser"}));
}

TEST(ScanJoinerNode, JoinsTheSegmentsOfATurn) {
  constexpr int kSegments = 12, kBeams = 30;
  const double step = 2.0 * M_PI / (kSegments * kBeams);
  ros::NodeHandle node;
  auto parts = node.advertise<sensor_msgs::LaserScan>("scan_parts", 100);
  ASSERT_TRUE(waitFor([&] { return parts.getNumSubscribers() == 1; }));
  std::vector<sensor_msgs::LaserScan> scans;
  const boost::function<void(const sensor_msgs::LaserScan&)> keep =
      [&](const sensor_msgs::LaserScan& scan) { scans.push_back(scan); };
  const auto subscriber = node.subscribe<sensor_msgs::LaserScan>("joined", 10, keep);
  for (int i = 0; i < 60 * kSegments && scans.size() < 3; ++i) {
    sensor_msgs::LaserScan segment;
    segment.header.stamp = ros::Time(1000.0 + i * 0.1 / kSegments);
    segment.header.frame_id = "laser";
    segment.angle_min = static_cast<float>((i % kSegments) * kBeams * step - M_PI);
    segment.angle_increment = static_cast<float>(step);
    segment.range_max = 10.0F;
    segment.ranges.assign(kBeams, 2.0F);
    parts.publish(segment);
    ros::spinOnce();
    ros::WallDuration(0.005).sleep();
  }
  ASSERT_GE(scans.size(), 3U);
  EXPECT_EQ(scans.back().ranges.size(), static_cast<std::size_t>(kSegments * kBeams));
  EXPECT_EQ(scans.back().header.frame_id, "laser");
  EXPECT_NEAR(scans.back().time_increment, 0.1 / (kSegments * kBeams), 1e-6);
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "replay_nodes_test");
  return RUN_ALL_TESTS();
}
