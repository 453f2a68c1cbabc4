// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <ros/service.h>
#include <std_srvs/SetBool.h>
#include <tf2_ros/transform_listener.h>

#include <cmath>

#include "kestrel_slam/ResetMapping.h"
#include "kestrel_slam/messages/conversions.h"
#include "mapper_client.h"

namespace kestrel {
namespace {

constexpr double kLimit_m = 0.05;
constexpr double kLimit_rad = 0.01;

void expectNear(const std::optional<Pose2>& actual, const Pose2& expected) {
  ASSERT_TRUE(actual) << "no pose was received";
  const Pose2 error = expected.inverse() * *actual;
  EXPECT_LT(error.distance(), kLimit_m);
  EXPECT_LT(std::abs(error.yaw), kLimit_rad);
}

TEST(LiveTransforms, WaitsForALateMounting) {
  MapperClient client("late");
  const TestFlight flight = laboratoryFlight(80);
  ASSERT_TRUE(client.connect());
  std::size_t i = 0;
  for (; i < 50; ++i) {  // 5 s at the laser's rate
    client.publish(messageOf(flight.scans[i].scan, "late_laser"));
    client.waitFor([] { return false; }, 0.1);
  }
  EXPECT_EQ(client.poses_received, 0U);
  auto report = client.report("Scans");
  EXPECT_EQ(report["level"], "2");
  const std::string text = report["message"];
  EXPECT_NE(text.find("'late_laser'"), std::string::npos) << text;
  EXPECT_NE(text.find("'late_base'"), std::string::npos) << text;
  EXPECT_NE(text.find("static_transform_publisher"), std::string::npos) << text;

  client.static_broadcaster.sendTransform(
      transformOf("late_base", "late_laser", Pose2(0.2, -0.1, 0.3), ros::Time::now()));
  ASSERT_TRUE(client.waitFor([&] { return client.poses_received > 0; }));
  for (; i < flight.scans.size(); ++i) {
    EXPECT_TRUE(client.match(messageOf(flight.scans[i].scan, "late_laser"))) << "scan " << i;
  }
  report = client.report("Scans");
  EXPECT_EQ(report["received"], "80");
  const int used = std::stoi(report["used"]);
  EXPECT_GE(used, 30) << "all scans after the transform";
  // Fifty scans waited, more than the queue can hold. The oldest scans were dropped and counted.
  const std::string overload = report["dropped: overload"];
  EXPECT_EQ(used + (overload.empty() ? 0 : std::stoi(overload)), 80);
  EXPECT_NE(report["level"], "2") << "no transform is missing now";
  EXPECT_EQ(client.parents["late_base"], std::set<std::string>{"map"});
}

TEST(LiveTransforms, LaserUpsideDownGivesTheSamePoses) {
  MapperClient client("flipped");
  const TestFlight flight = laboratoryFlight(150);
  geometry_msgs::TransformStamped mounting =
      transformOf("flipped_base", "flipped_laser", Pose2(), ros::Time::now());
  mounting.transform.rotation.x = 1.0;  // half a turn about x: y and z point the other way
  mounting.transform.rotation.w = 0.0;
  client.static_broadcaster.sendTransform(mounting);
  ASSERT_TRUE(client.connect());
  std::optional<Pose2> pose;
  for (const SimulatedScan& step : flight.scans) {
    sensor_msgs::LaserScan message = messageOf(step.scan, "flipped_laser");
    message.angle_min = -message.angle_min;
    message.angle_increment = -message.angle_increment;
    pose = client.match(message);
    ASSERT_TRUE(pose);
  }
  expectNear(pose, flight.truth(flight.scans.size() - 1));
}

/// Odometry that drifts by a known amount. map -> odom must correct the drift.
class DriftingOdometry {
 public:
  explicit DriftingOdometry(const TestFlight& flight, const std::string& odom = "odom",
                            const std::string& base = "odom_base")
      : flight_(flight), odom_(odom), base_(base) {}

  Pose2 odom_T_base(std::size_t i) const {
    const double drift = 1e-3 * static_cast<double>(i);  // m and rad per scan
    return Pose2(2.0, 1.0, 0.5) * flight_.truth(i) * Pose2(drift, 0.0, drift);
  }
  geometry_msgs::TransformStamped message(std::size_t i) const {
    return transformOf(odom_, base_, odom_T_base(i), ros::Time(flight_.scans[i].scan.stamp));
  }

 private:
  const TestFlight& flight_;
  std::string odom_, base_;
};

TEST(LiveTransforms, OdometryGetsTheCorrection) {
  MapperClient client("odometry");
  const TestFlight flight = laboratoryFlight(200);
  const DriftingOdometry odometry(flight);
  ASSERT_TRUE(client.connect());
  client.static_broadcaster.sendTransform(
      transformOf("odom_base", "odom_laser", Pose2(), ros::Time::now()));

  // Without odometry there must be no pose and no transform, not even an identity transform.
  client.publish(messageOf(flight.scans[0].scan, "odom_laser"));
  EXPECT_FALSE(client.waitFor([&] { return client.parents.count("odom") > 0; }, 1.5));
  EXPECT_EQ(client.poses_received, 0U);

  std::optional<Pose2> pose;
  for (std::size_t i = 0; i < flight.scans.size(); ++i) {
    client.broadcaster.sendTransform(odometry.message(i));
    pose = client.match(messageOf(flight.scans[i].scan, "odom_laser", i == 0 ? 1e-6 : 0.0), 0.5);
    ASSERT_TRUE(pose || i == 0) << "scan " << i;
  }
  const std::size_t last = flight.scans.size() - 1;
  expectNear(pose, flight.truth(last));

  const ros::Time dated = ros::Time(flight.scans[last].scan.stamp) + ros::Duration(0.1);
  ASSERT_TRUE(client.waitFor([&] { return client.lastTransform("odom").header.stamp == dated; }));
  EXPECT_EQ(client.parents["odom"], std::set<std::string>{"map"});
  EXPECT_EQ(client.parents["odom_base"], std::set<std::string>{"odom"});
  const Pose2 map_T_odom = poseOf(client.lastTransform("odom").transform);
  const Pose2 difference = (map_T_odom * odometry.odom_T_base(last)).inverse() * *pose;
  EXPECT_LT(difference.distance(), 1e-9);
  EXPECT_LT(std::abs(difference.yaw), 1e-9);
}

/// What a user says during a pause holds: the old map -> odom must not come back on resume.
TEST(LiveTransforms, APoseSetDuringAPauseSurvivesTheResume) {
  MapperClient client("paused");
  const TestFlight flight = laboratoryFlight(60);
  const DriftingOdometry odometry(flight, "paused_odom", "paused_base");
  ASSERT_TRUE(client.connect());
  client.static_broadcaster.sendTransform(
      transformOf("paused_base", "paused_laser", Pose2(), ros::Time::now()));
  const auto send = [&](std::size_t i) {
    client.broadcaster.sendTransform(odometry.message(i));
    return client.match(messageOf(flight.scans[i].scan, "paused_laser"), 0.5);
  };
  for (std::size_t i = 0; i < 40; ++i) send(i);

  std_srvs::SetBool pause;
  pause.request.data = true;
  ASSERT_TRUE(ros::service::call("paused/pause_mapping", pause));
  EXPECT_FALSE(send(40));
  kestrel_slam::ResetMapping restart;
  const Pose2 start(10.0, 5.0, 1.0);
  restart.request.initial_pose = toMessage(start);
  ASSERT_TRUE(ros::service::call("paused/restart_mapping_with_new_pose", restart));
  for (std::size_t i = 41; i < 45; ++i) EXPECT_FALSE(send(i));
  pause.request.data = false;
  ASSERT_TRUE(ros::service::call("paused/pause_mapping", pause));

  std::optional<Pose2> pose;
  for (std::size_t i = 45; i < 50; ++i) pose = send(i);
  expectNear(pose, start * (flight.truth(41).inverse() * flight.truth(49)));
}

TEST(LiveTransforms, OdometryFrameEqualToTheBaseMeansNoOdometry) {
  MapperClient client("same");
  const TestFlight flight = laboratoryFlight(5);
  ASSERT_TRUE(client.connect());
  EXPECT_TRUE(client.match(messageOf(flight.scans[0].scan, "same_base")));
  ASSERT_TRUE(client.waitFor([&] { return client.parents.count("same_base") > 0; }));
  EXPECT_EQ(client.parents["same_base"], std::set<std::string>{"map"});
}

/// The laser counts from its start, tf has the time of day. A rigid mounting needs no time.
TEST(LiveTransforms, AMountingOnAnotherClockIsUsed) {
  MapperClient client("clock");
  const TestFlight flight = laboratoryFlight(20);
  ASSERT_TRUE(client.connect());
  std::optional<Pose2> pose;
  std::size_t used = 0;
  for (std::size_t i = 0; i < flight.scans.size(); ++i) {
    const ros::Time now(1700000000.0 + 0.1 * static_cast<double>(i));
    client.broadcaster.sendTransform(transformOf("clock_base", "clock_laser", Pose2(), now));
    pose = client.match(messageOf(flight.scans[i].scan, "clock_laser"), 1.0);
    if (pose) ++used;
  }
  EXPECT_GE(used, 15U);
  expectNear(pose, flight.truth(flight.scans.size() - 1));
}

TEST(LiveTransforms, TransformsCanBeSwitchedOff) {
  MapperClient client("silent");
  const TestFlight flight = laboratoryFlight(5);
  ASSERT_TRUE(client.connect());
  for (const SimulatedScan& step : flight.scans) {
    EXPECT_TRUE(client.match(messageOf(step.scan, "silent_base")));
  }
  EXPECT_FALSE(client.waitFor([&] { return client.parents.count("silent_base") > 0; }, 0.3));
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_transforms_test");
  return RUN_ALL_TESTS();
}
