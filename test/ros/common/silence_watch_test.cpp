// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/silence_watch.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

constexpr std::size_t kMaxLine = 200;
const std::vector<NeededTopic> kScan = {{"/scan", "sensor_msgs/LaserScan"}};

std::string reasonFor(const RosGraph& graph) {
  const std::string reason = silenceReason(kScan, "~scan_topic", graph);
  EXPECT_LT(("There is no scan on /scan for 1000 s: " + reason).size(), kMaxLine) << reason;
  return reason;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Silence, NobodyPublishes) {
  EXPECT_TRUE(contains(reasonFor({}), "nobody publishes it, and no other LaserScan"));
}

TEST(Silence, AnotherTopicHasTheType) {
  RosGraph graph;
  graph.published = {{"/front/scan", "sensor_msgs/LaserScan"},
                     {"/points", "sensor_msgs/PointCloud2"},
                     {"/uav/planar_scan_view", "sensor_msgs/LaserScan"}};
  const std::string reason = reasonFor(graph);
  EXPECT_TRUE(contains(reason, "/front/scan")) << reason;
  EXPECT_TRUE(contains(reason, "~scan_topic")) << reason;
  EXPECT_FALSE(contains(reason, "/points")) << reason;
  EXPECT_FALSE(contains(reason, "planar_scan_view")) << reason;
}

TEST(Silence, ManyLongNamesStayOneLine) {
  RosGraph graph;
  for (const char c : {'a', 'b', 'c', 'd', 'e'}) {
    graph.published["/" + std::string(300, c)] = "sensor_msgs/LaserScan";
  }
  reasonFor(graph);
}

TEST(Silence, AWrongTypeIsNamed) {
  RosGraph graph;
  graph.published = {{"/scan", "sensor_msgs/PointCloud2"}};
  const std::string reason = reasonFor(graph);
  EXPECT_TRUE(contains(reason, "sensor_msgs/PointCloud2, not sensor_msgs/LaserScan")) << reason;
}

TEST(Silence, APublisherWithoutMessages) {
  RosGraph graph;
  graph.published = {{"/scan", "sensor_msgs/LaserScan"}};
  EXPECT_TRUE(contains(reasonFor(graph), "ROS_IP"));
  graph.connected = 1;
  EXPECT_TRUE(contains(reasonFor(graph), "1 publisher(s), but no message"));
}

TEST(Silence, AMissingClockComesFirst) {
  RosGraph graph;
  graph.clock_is_missing = true;
  EXPECT_TRUE(contains(reasonFor(graph), "/clock"));
}

}  // namespace
}  // namespace kestrel
