// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <std_srvs/Trigger.h>
#include <visualization_msgs/MarkerArray.h>

#include <cmath>

#include "graph/loop_world.h"
#include "mapper_client.h"
#include "ros/mapper/ring_scan.h"

namespace kestrel {
namespace {

std::size_t linesOf(const visualization_msgs::MarkerArray& markers, const std::string& ns) {
  for (const auto& marker : markers.markers) {
    if (marker.ns == ns) return marker.points.size() / 2;
  }
  return 0;
}

TEST(LiveLoops, ALoopIsClosedAndShown) {
  MapperClient client;
  visualization_msgs::MarkerArray graph, loops, submaps;
  const auto graph_subscriber = client.nh.subscribe<visualization_msgs::MarkerArray>(
      "graph_markers", 1, [&](const visualization_msgs::MarkerArrayConstPtr& m) { graph = *m; });
  const auto loop_subscriber = client.nh.subscribe<visualization_msgs::MarkerArray>(
      "loop_closures", 1, [&](const visualization_msgs::MarkerArrayConstPtr& m) { loops = *m; });
  const auto submap_subscriber = client.nh.subscribe<visualization_msgs::MarkerArray>(
      "submaps", 1, [&](const visualization_msgs::MarkerArrayConstPtr& m) { submaps = *m; });
  ASSERT_TRUE(client.connect());
  const ros::Time start = ros::Time::now();
  const std::vector<Pose2> poses = loop_world::laps(1.3);
  std::optional<Pose2> estimated;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const ros::Time stamp = start + ros::Duration(0.1 * static_cast<double>(i));
    estimated = client.match(messageAt(poses[i], stamp));
    ASSERT_TRUE(estimated) << "no pose for scan " << i;
  }
  EXPECT_TRUE(client.waitFor([&] { return linesOf(graph, "accepted") > 3; }))
      << linesOf(graph, "accepted") << " loops are shown as accepted";
  EXPECT_TRUE(client.waitFor([&] { return !loops.markers.empty(); }))
      << "they come after those of the graph";
  EXPECT_TRUE(client.waitFor([&] { return submaps.markers.size() > 2; }))
      << "a path and a name for each finished submap";
  const Pose2 truth = poses.front().between(poses.back());
  EXPECT_LT(truth.between(*estimated).distance(), 0.15);
  std_srvs::Trigger reset;
  ASSERT_TRUE(ros::service::call("reset_map", reset));
  const ros::Time later = start + ros::Duration(1000.0);
  estimated = client.match(messageAt(poses[0], later));
  ASSERT_TRUE(estimated);
  EXPECT_LT(estimated->distance(), 0.01) << "the correction belongs to the deleted map";
  EXPECT_TRUE(client.waitFor([&] { return linesOf(graph, "accepted") == 0; }));
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_loops_test");
  return RUN_ALL_TESTS();
}
