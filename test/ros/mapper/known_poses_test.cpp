// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "mapper_client.h"

namespace kestrel {
namespace {

constexpr double kRounding = 1e-6;

void expectEqual(const std::optional<Pose2>& actual, const Pose2& expected) {
  ASSERT_TRUE(actual) << "no pose was received";
  const Pose2 error = expected.inverse() * *actual;
  EXPECT_LT(error.distance(), kRounding);
  EXPECT_LT(std::abs(error.yaw), kRounding);
}

/// A flight whose poses are published in tf as `parent` -> base.
struct KnownFlight {
  KnownFlight(const std::string& ns, std::string parent_frame)
      : client(ns), base(ns + "/base_link"), parent(std::move(parent_frame)) {}

  std::optional<Pose2> match(std::size_t i, const Pose2& pose) {
    const sensor_msgs::LaserScan scan = messageOf(flight.scans[i].scan, base);
    client.broadcaster.sendTransform(transformOf(parent, base, pose, scan.header.stamp));
    return client.match(scan);
  }

  MapperClient client;
  TestFlight flight = laboratoryFlight(40);
  std::string base, parent;
};

TEST(KnownPoses, OfAnOdometryAreThePosesOfTheMapper) {
  KnownFlight known("odometry", "odom");
  ASSERT_TRUE(known.client.connect());
  const Pose2 odom_T_world(5.0, -3.0, 0.5);
  for (std::size_t i = 0; i < 30; ++i) {
    const Pose2 pose = odom_T_world * known.flight.truth(i);
    expectEqual(known.match(i, pose), pose);
  }
  EXPECT_EQ(known.client.report("Match")["state"], "ok");
  // The map agrees with the poses: the same scan a little beside its place fits badly.
  const Pose2 wrong = odom_T_world * known.flight.truth(30) * Pose2(0.7, 0.4, 0.1);
  expectEqual(known.match(30, wrong), wrong);
  EXPECT_EQ(known.client.report("Match")["state"], "degraded");
  EXPECT_EQ(known.client.diagnosis("Match", "reason"), "poor fit");
  ASSERT_EQ(known.client.transforms.count("odom"), 1U) << "map -> odom is the identity";
  EXPECT_LT(poseOf(known.client.lastTransform("odom").transform).distance(), kRounding);
  EXPECT_TRUE(known.client.waitFor([&] {
    const auto& cells = known.client.map.data;
    return std::count(cells.begin(), cells.end(), 100) > 100;
  })) << "no walls in the map";
}

TEST(KnownPoses, OfAnotherLocalizationAreNotPublishedAgain) {
  KnownFlight known("external", "map");
  ASSERT_TRUE(known.client.connect());
  std::string text;
  for (std::size_t i = 0; i < 10 && text.find("~map_with_known_poses") == std::string::npos; ++i) {
    known.client.publish(messageOf(known.flight.scans[i].scan, known.base));
    text = known.client.report("Scans")["message"];
  }
  EXPECT_NE(text.find("~map_with_known_poses needs it"), std::string::npos) << text;
  for (std::size_t i = 20; i < 40; ++i) {
    const Pose2 pose = known.flight.truth(i);
    expectEqual(known.match(i, pose), pose);
  }
  for (const auto& [child, parents] : known.client.parents) {
    EXPECT_NE(child, "odom") << "without odometry there is no such frame";
  }
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "known_poses_test");
  const ros::NodeHandle keeps_the_node_alive;
  return RUN_ALL_TESTS();
}
