// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <nav_msgs/GetMap.h>
#include <std_msgs/String.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <string>

#include "kestrel_slam/ResetMapping.h"
#include "kestrel_slam/SaveMap.h"
#include "kestrel_slam/map/map_io.h"
#include "kestrel_slam/messages/conversions.h"
#include "mapper_client.h"

namespace kestrel {
namespace {

constexpr double kLimit_m = 0.05;
constexpr double kLimit_rad = 0.01;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

void expectNear(const std::optional<Pose2>& actual, const Pose2& expected) {
  ASSERT_TRUE(actual) << "no pose was received";
  const Pose2 error = expected.inverse() * *actual;
  EXPECT_LT(error.distance(), kLimit_m);
  EXPECT_LT(std::abs(error.yaw), kLimit_rad);
}

/// Sends commands to a node. The scans are in the base frame, so that no mounting is needed.
class LiveServices : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    client_ = new MapperClient;
    flight_ = new TestFlight(laboratoryFlight(300));
    initial_pose_ =
        client_->nh.advertise<geometry_msgs::PoseWithCovarianceStamped>("initialpose", 1);
    command_ = client_->nh.advertise<std_msgs::String>("syscommand", 1);
    ASSERT_TRUE(client_->connect()) << "the mapper does not subscribe to scan";
    ASSERT_TRUE(client_->waitFor(
        [] { return initial_pose_.getNumSubscribers() > 0 && command_.getNumSubscribers() > 0; }));
  }
  static void TearDownTestSuite() {
    initial_pose_ = ros::Publisher();
    command_ = ros::Publisher();
    delete client_;
    delete flight_;
  }

  void SetUp() override {
    setPaused(false);
    std_srvs::Trigger reset;
    ASSERT_TRUE(ros::service::call("reset_map", reset));
    EXPECT_TRUE(reset.response.success);
  }

  /// Maps scans [from, to) and returns the last pose. Every test uses different stamps.
  static std::optional<Pose2> fly(std::size_t from, std::size_t to) {
    std::optional<Pose2> pose;
    for (std::size_t i = from; i < to; ++i) {
      pose = client_->match(message(i));
      if (!pose) break;
    }
    return pose;
  }

  static sensor_msgs::LaserScan message(std::size_t i) {
    shift_s_ += 0.1;
    return messageOf(flight_->scans[i].scan, "base_link",
                     shift_s_ + flight_->scans[0].scan.stamp - flight_->scans[i].scan.stamp);
  }

  static std_srvs::SetBool::Response setPaused(bool paused) {
    std_srvs::SetBool service;
    service.request.data = paused;
    EXPECT_TRUE(ros::service::call("pause_mapping", service));
    return service.response;
  }

  static void place(const std::string& frame, const Pose2& pose) {
    geometry_msgs::PoseWithCovarianceStamped message;
    message.header.frame_id = frame;
    message.pose.pose = toMessage(pose);
    message.pose.pose.position.x = pose.x;
    initial_pose_.publish(message);
    client_->waitFor([] { return false; },
                     0.2);  // wait, because it uses another connection than the scans
  }

  static bool hasMap() {
    nav_msgs::GetMap service;
    return ros::service::call("dynamic_map", service);
  }
  /// The graph's thread makes the map in its own time.
  static bool getsMap() { return client_->waitFor(hasMap, 20.0); }

  inline static MapperClient* client_ = nullptr;
  inline static TestFlight* flight_ = nullptr;
  inline static double shift_s_ = 0.0;
  inline static ros::Publisher initial_pose_, command_;
};

TEST_F(LiveServices, ResetDeletesTheMap) {
  expectNear(fly(0, 100), flight_->truth(99));
  ASSERT_TRUE(getsMap());
  std_srvs::Trigger reset;
  ASSERT_TRUE(ros::service::call("reset_map", reset));
  EXPECT_TRUE(reset.response.success);
  EXPECT_FALSE(hasMap());
  expectNear(fly(100, 101), Pose2());
  EXPECT_TRUE(getsMap());
}

TEST_F(LiveServices, SysCommandResets) {
  fly(0, 100);
  std_msgs::String text;
  text.data = "savegeotiff";  // a command for another node; it is ignored here
  command_.publish(text);
  text.data = "reset";
  command_.publish(text);
  EXPECT_TRUE(client_->waitFor([] { return !hasMap(); }));
  expectNear(fly(100, 101), Pose2());
}

TEST_F(LiveServices, RestartStartsAtTheGivenPose) {
  fly(0, 50);
  const Pose2 start(3.0, -2.0, 1.5);
  kestrel_slam::ResetMapping service;
  service.request.initial_pose = toMessage(start);
  ASSERT_TRUE(ros::service::call("restart_mapping_with_new_pose", service));
  EXPECT_TRUE(service.response.success);
  EXPECT_NE(service.response.message.find("x 3.00 m"), std::string::npos);
  EXPECT_FALSE(hasMap());
  const Pose2 motion = flight_->truth(50).inverse() * flight_->truth(99);
  expectNear(fly(50, 100), start * motion);
}

TEST_F(LiveServices, RestartRefusesNan) {
  fly(0, 2);
  kestrel_slam::ResetMapping service;
  service.request.initial_pose.orientation.w = 1.0;
  service.request.initial_pose.position.x = kNan;
  ASSERT_TRUE(ros::service::call("restart_mapping_with_new_pose", service));
  EXPECT_FALSE(service.response.success);
  EXPECT_NE(service.response.message.find("not finite"), std::string::npos);
  service.request.initial_pose.position.x = 0.0;
  service.request.initial_pose.orientation.w = 0.0;  // not a valid rotation
  ASSERT_TRUE(ros::service::call("restart_mapping_with_new_pose", service));
  EXPECT_FALSE(service.response.success);
  service.request.initial_pose = toMessage(Pose2(500000.0, 0.0, 0.0));
  ASSERT_TRUE(ros::service::call("restart_mapping_with_new_pose", service));
  EXPECT_FALSE(service.response.success);
  EXPECT_NE(service.response.message.find("more than 10000 m"), std::string::npos);
  EXPECT_TRUE(getsMap()) << "a refused restart must not delete the map";
}

TEST_F(LiveServices, PauseStopsAndContinues) {
  fly(0, 50);
  EXPECT_TRUE(setPaused(true).success);
  EXPECT_EQ(setPaused(true).message, "mapping was already paused");
  const std::size_t before = client_->poses_received;
  for (std::size_t i = 50; i < 55; ++i) client_->publish(message(i));
  EXPECT_FALSE(client_->waitFor([&] { return client_->poses_received > before; }, 0.5));
  EXPECT_EQ(client_->diagnosis("Scans", "message"), "paused");
  EXPECT_EQ(setPaused(false).message, "mapping is now running");
  expectNear(fly(55, 60), flight_->truth(59));
}

TEST_F(LiveServices, InitialPoseMovesTheVehicleWithinTheMap) {
  fly(0, 200);
  for (int i = 0; i < 3; ++i) {  // also if it is repeated
    place("map", flight_->truth(20) * Pose2(0.1, -0.1, 0.05));
    expectNear(fly(20, 21), flight_->truth(20));
    place("/map", flight_->truth(150) * Pose2(-0.1, 0.1, -0.05));
    expectNear(fly(150, 151), flight_->truth(150));
  }
}

TEST_F(LiveServices, ALostPoseIsNotPublishedAsAMeasurement) {
  fly(0, 100);
  place("map", flight_->truth(99) * Pose2(300.0, 200.0, 1.0));  // nothing is mapped there
  const sensor_msgs::LaserScan scan = message(100);
  client_->publish(scan);
  ASSERT_TRUE(client_->waitFor([&] { return client_->pose.header.stamp == scan.header.stamp; }));
  ASSERT_EQ(client_->diagnosis("Match", "state"), "lost");
  EXPECT_LT(client_->pose_update.header.stamp, client_->pose.header.stamp);
}

TEST_F(LiveServices, InvalidInitialPosesAreRefused) {
  fly(0, 50);
  place("odom", Pose2(5.0, 5.0, 1.0));
  place("", Pose2(5.0, 5.0, 1.0));
  Pose2 nan;
  nan.x = kNan;
  place("map", nan);
  place("map", Pose2(500000.0, 0.0, 0.0));
  expectNear(fly(50, 51), flight_->truth(50));
}

TEST_F(LiveServices, SavedMapEqualsThePublishedOne) {
  fly(0, 100);
  char folder[] = "/tmp/kestrel_save_map_XXXXXX";
  ASSERT_NE(mkdtemp(folder), nullptr);
  kestrel_slam::SaveMap service;
  service.request.path = std::string(folder) + "/room";
  ASSERT_TRUE(ros::service::call("save_map", service));
  ASSERT_TRUE(service.response.success) << service.response.message;
  EXPECT_NE(service.response.message.find("room.yaml"), std::string::npos);
  const MapSnapshot saved = readMap(service.request.path + ".yaml");
  nav_msgs::GetMap published;
  ASSERT_TRUE(ros::service::call("dynamic_map", published));
  EXPECT_EQ(saved.cells, published.response.map.data);
  EXPECT_DOUBLE_EQ(saved.origin_x, published.response.map.info.origin.position.x);
  EXPECT_DOUBLE_EQ(saved.origin_y, published.response.map.info.origin.position.y);
  std::filesystem::remove_all(folder);
}

TEST_F(LiveServices, OddNamesOfMapsAreQuotedOrCompleted) {
  fly(0, 20);
  char folder[] = "/tmp/kestrel_save_map_XXXXXX";
  ASSERT_NE(mkdtemp(folder), nullptr);
  const std::pair<const char*, const char*> names[] = {
      {"#1", "#1.yaml"},        {"a: b", "a: b.yaml"}, {"[a] b", "[a] b.yaml"},
      {"new/", "new/map.yaml"}, {"m.pgm", "m.yaml"},   {"deep/er/m", "deep/er/m.yaml"}};
  for (const auto& [name, file] : names) {
    kestrel_slam::SaveMap service;
    service.request.path = std::string(folder) + "/" + name;
    ASSERT_TRUE(ros::service::call("save_map", service));
    EXPECT_TRUE(service.response.success) << service.response.message;
    EXPECT_NO_THROW(readMap(std::string(folder) + "/" + file)) << name;
  }
  std::filesystem::remove_all(folder);
}

TEST_F(LiveServices, SaveMapSaysWhyItFails) {
  kestrel_slam::SaveMap service;
  ASSERT_TRUE(ros::service::call("save_map", service));
  EXPECT_FALSE(service.response.success);
  EXPECT_NE(service.response.message.find("is empty"), std::string::npos);
  fly(0, 2);
  for (const char* path : {"/nowhere/at/all", "/dev/null.pgm", "../../escape"}) {
    service.request.path = path;
    ASSERT_TRUE(ros::service::call("save_map", service));
    EXPECT_FALSE(service.response.success);
    EXPECT_NE(service.response.message.find("save_folder"), std::string::npos)
        << service.response.message;
  }
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_services_test");
  return RUN_ALL_TESTS();
}
