// SPDX-License-Identifier: BSD-3-Clause
// Localizes with a real mapper node in the picture of a map. The test starts the node itself.
#include <gtest/gtest.h>
#include <std_srvs/Trigger.h>

#include <filesystem>

#include "kestrel_slam/ResetMapping.h"
#include "kestrel_slam/SaveSession.h"
#include "kestrel_slam/SetMode.h"
#include "kestrel_slam/map/map_io.h"
#include "kestrel_slam/messages/conversions.h"
#include "mapper_client.h"
#include "room.h"
#include "ros/mapper/mapper_process.h"
#include "ros/mapper/ring_scan.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

using Node = MapperProcess;

sensor_msgs::LaserScan inRoom(const Pose2& pose, const ros::Time& stamp) {
  return messageAt(pose, stamp, room::walls());
}

class LiveLocalization : public ::testing::Test {
 protected:
  void SetUp() override {
    client_.emplace();
    placing_ = client_->nh.advertise<geometry_msgs::PoseWithCovarianceStamped>("initialpose", 1);
    writeMap(folder_.file("yesterday"), room::map().grid().snapshot());
  }

  std::vector<std::string> inPicture() const {
    return {"_mode:=localization", "_map_file:=" + folder_.file("yesterday.yaml")};
  }
  std::string inFolder() const { return "_session_folder:=" + folder_.file(""); }

  /// Distance of the pose from the truth after at most `scans` scans at one place, m.
  double errorAt(const Pose2& truth, int scans) {
    double error = 1e9;
    for (int i = 0; i < scans && error > 0.1; ++i) {
      stamp_ += ros::Duration(0.1);
      const double patience_s = scans > 1 ? 0.5 : 10.0;  // while it is lost, no pose is published
      const std::optional<Pose2> pose = client_->match(inRoom(truth, stamp_), patience_s);
      error = pose ? truth.between(*pose).distance() : 1e9;
    }
    return error;
  }

  /// Moves on from `truth` and returns the largest error.
  double follow(Pose2& truth, int scans, const Pose2& step = {0.03, 0.0, 0.02}) {
    double largest = 0.0;
    for (int i = 0; i < scans; ++i) {
      truth = truth * step;
      largest = std::max(largest, errorAt(truth, 1));
    }
    return largest;
  }

  void place(const Pose2& pose) {
    ASSERT_TRUE(client_->waitFor([&] { return placing_.getNumSubscribers() > 0; }));
    geometry_msgs::PoseWithCovarianceStamped message;
    message.header.frame_id = "map";
    message.pose.pose = toMessage(pose);
    placing_.publish(message);
    client_->waitFor([] { return false; }, 0.3);  // it uses another connection than the scans
  }

  static std_srvs::Trigger::Response trigger(const std::string& name) {
    std_srvs::Trigger service;
    EXPECT_TRUE(ros::service::call(name, service));
    return service.response;
  }

  static kestrel_slam::SetMode::Response setMode(const std::string& mode) {
    kestrel_slam::SetMode service;
    service.request.mode = mode;
    EXPECT_TRUE(ros::service::call("set_mode", service));
    return service.response;
  }

  std::string mode() { return client_->diagnosis("Match", "mode"); }

  TemporaryFolder folder_;
  std::optional<MapperClient> client_;
  ros::Publisher placing_;
  ros::Time stamp_ = ros::Time::now();
};

TEST_F(LiveLocalization, FindsTheVehicleInAPictureAndFollowsIt) {
  Node node(inPicture());
  ASSERT_TRUE(client_->connect());
  Pose2 truth(1, -1, 2.1);
  EXPECT_LT(errorAt(truth, 30), 0.1);
  EXPECT_LT(follow(truth, 10), 0.1);
  EXPECT_EQ(mode(), "localization");
  for (const char* name : {"relocalize", "reset_map"}) {
    const auto answer = trigger(name);
    EXPECT_TRUE(answer.success) << answer.message;
    EXPECT_NE(answer.message.find("whole map"), std::string::npos) << answer.message;
    EXPECT_LT(errorAt(Pose2(-2.5, 1.8, -1.2), 30), 0.1) << name;
  }
  const auto refused = setMode("mapping");
  EXPECT_FALSE(refused.success);
  EXPECT_NE(refused.message.find("map_file does not grow"), std::string::npos) << refused.message;
}

TEST_F(LiveLocalization, TakesPosesOfAUserAnyNumberOfTimes) {
  Node node(inPicture());
  ASSERT_TRUE(client_->connect());
  for (const Pose2& truth :
       {Pose2(1, -1, 2.1), Pose2(-2.5, 1.8, -1.2), Pose2(0.5, 0.4, 0.0), Pose2(1, -1, 2.1)}) {
    place(truth * Pose2(0.1, -0.1, 0.1));
    EXPECT_LT(errorAt(truth, 1), 0.1);
  }
  const Pose2 truth(-2.5, 1.8, -1.2);
  kestrel_slam::ResetMapping service;
  service.request.initial_pose = toMessage(truth * Pose2(0.1, 0.1, -0.1));
  service.request.initial_pose.position.x = (truth * Pose2(0.1, 0.1, -0.1)).x;
  ASSERT_TRUE(ros::service::call("restart_mapping_with_new_pose", service));
  EXPECT_TRUE(service.response.success);
  EXPECT_NE(service.response.message.find("the map is kept"), std::string::npos);
  EXPECT_LT(errorAt(truth, 1), 0.1);
}

TEST_F(LiveLocalization, ChangesBetweenMappingAndLocalization) {
  Node node({"_graph:=true", inFolder()});
  ASSERT_TRUE(client_->connect());
  EXPECT_FALSE(trigger("relocalize").success) << "it maps";
  auto answer = setMode("localization");
  EXPECT_FALSE(answer.success);
  EXPECT_NE(answer.message.find("no map yet"), std::string::npos) << answer.message;
  place(Pose2());
  Pose2 truth(0, 0, 0);
  EXPECT_LT(errorAt(truth, 1), 0.1);
  EXPECT_LT(follow(truth, 60, {0.02, 0.0, 0.05}), 0.1);
  for (int i = 0; i < 2; ++i) {
    answer = setMode("localization");
    ASSERT_TRUE(answer.success) << answer.message;
    EXPECT_EQ(mode(), "localization");
    EXPECT_LT(follow(truth, 20, {0.02, 0.0, 0.05}), 0.1);
    answer = setMode("mapping");
    ASSERT_TRUE(answer.success) << answer.message;
    EXPECT_EQ(mode(), "mapping");
    EXPECT_LT(follow(truth, 40, {0.02, 0.0, 0.05}), 0.1);
  }
  EXPECT_NE(setMode("mapping").message.find("already"), std::string::npos);
  EXPECT_NE(setMode("sleeping").message.find("must be mapping or localization"), std::string::npos);
}

TEST_F(LiveLocalization, ASessionIsAMapToLocalizeInAndCanBeContinued) {
  {
    Node node({"_graph:=true", inFolder()});
    ASSERT_TRUE(client_->connect());
    Pose2 truth(0, 0, 0);
    EXPECT_LT(errorAt(truth, 1), 0.1);
    EXPECT_LT(follow(truth, 130, {0.02, 0.0, 0.05}), 0.1);
    kestrel_slam::SaveSession service;
    service.request.path = "room";
    ASSERT_TRUE(ros::service::call("save_session", service));
    ASSERT_TRUE(service.response.success) << service.response.message;
  }
  client_.reset();
  SetUp();
  Node node({"_mode:=localization", "_session:=" + folder_.file("room.session"), inFolder()});
  ASSERT_TRUE(client_->connect());
  Pose2 truth(1, -1, 2.1);
  EXPECT_LT(errorAt(truth, 30), 0.1);
  EXPECT_EQ(mode(), "localization");
  const auto answer = setMode("mapping");
  ASSERT_TRUE(answer.success) << answer.message;
  EXPECT_LT(follow(truth, 20), 0.1);
  EXPECT_EQ(mode(), "mapping");
}

TEST_F(LiveLocalization, SaysWhatIsWrongWithTheMap) {
  for (const std::string& file : {std::string("/nowhere/map.yaml"), folder_.file("yesterday.pgm")})
    EXPECT_NE(Node({"_mode:=localization", "_map_file:=" + file}).wait(), 0);
  EXPECT_NE(Node({"_mode:=localization"}).wait(), 0);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_localization_test");
  const ros::NodeHandle started;  // the fixtures use the time of ROS
  return RUN_ALL_TESTS();
}
