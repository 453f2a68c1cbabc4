// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <std_msgs/String.h>
#include <std_srvs/Trigger.h>
#include <visualization_msgs/MarkerArray.h>

#include <cmath>
#include <filesystem>

#include "kestrel_slam/GetDistanceToObstacle.h"
#include "kestrel_slam/GetRecoveryInfo.h"
#include "kestrel_slam/GetRobotTrajectory.h"
#include "kestrel_slam/GetSearchPosition.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/messages/conversions.h"
#include "mapper_client.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

/// Flies into the laboratory, once for all tests.
class HectorCompanions : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    client_ = new MapperClient;
    ASSERT_TRUE(client_->connect());
    const TestFlight flight = laboratoryFlight(120);
    for (const SimulatedScan& scan : flight.scans) {
      ASSERT_TRUE(client_->match(messageOf(scan.scan, "base_link")));
    }
    ASSERT_TRUE(client_->waitFor([] { return !client_->map.data.empty(); }));
  }
  static void TearDownTestSuite() { delete client_; }

  /// Calls until the node has the map.
  template <typename Service>
  static bool call(const std::string& name, Service& service) {
    return client_->waitFor([&] { return ros::service::call(name, service); });
  }

  static MapperClient* client_;
};

MapperClient* HectorCompanions::client_ = nullptr;

TEST_F(HectorCompanions, TheTrajectoryEndsAtThePose) {
  kestrel_slam::GetRobotTrajectory service;
  ASSERT_TRUE(call("trajectory", service));
  ASSERT_GT(service.response.trajectory.poses.size(), 5U);
  const Pose2 last = poseOf(service.response.trajectory.poses.back().pose);
  EXPECT_LT((last.inverse() * poseOf(client_->pose.pose)).distance(), 0.1);
  EXPECT_EQ(service.response.trajectory.header.frame_id, "map");

  kestrel_slam::GetRecoveryInfo back;
  back.request.request_time = service.response.trajectory.poses.back().header.stamp;
  back.request.request_radius = 0.2;
  ASSERT_TRUE(call("trajectory_recovery_info", back));
  const Pose2 entry = poseOf(back.response.radius_entry_pose.pose);
  EXPECT_GE((last.inverse() * entry).distance(), 0.2);
  EXPECT_LT((last.inverse() * entry).distance(), 0.4);
}

/// The laboratory has walls all around, apart from what was not seen yet.
TEST_F(HectorCompanions, ObstaclesAreAllAround) {
  constexpr int kDirections = 8;
  const Pose2 base = poseOf(client_->pose.pose);
  int found = 0;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2.0 * kPi * i / kDirections;
    kestrel_slam::GetDistanceToObstacle service;
    service.request.point.header.frame_id = "base_link";
    service.request.point.point.x = std::cos(angle);
    service.request.point.point.y = std::sin(angle);
    ASSERT_TRUE(call("get_distance_to_obstacle", service));
    if (service.response.distance < 0.0F) continue;
    ++found;
    const geometry_msgs::Point& end = service.response.end_point.point;
    EXPECT_NEAR(std::hypot(end.x - base.x, end.y - base.y), service.response.distance, 0.1);
    EXPECT_NEAR(normalizeAngle(std::atan2(end.y - base.y, end.x - base.x) - base.yaw - angle), 0.0,
                0.1);
    EXPECT_EQ(service.response.end_point.header.frame_id, "map");
  }
  EXPECT_GE(found, kDirections / 2);
}

TEST_F(HectorCompanions, TheSearchPositionIsInFrontOfTheObject) {
  kestrel_slam::GetSearchPosition service;
  service.request.ooi_pose.header.frame_id = "map";
  service.request.ooi_pose.pose = toMessage(Pose2(1.0, 2.0, kPi / 2.0));
  service.request.distance = 0.5F;
  ASSERT_TRUE(call("get_search_position", service));
  EXPECT_NEAR(service.response.search_pose.pose.position.x, 1.0, 1e-6);
  EXPECT_NEAR(service.response.search_pose.pose.position.y, 1.5, 1e-6);
}

TEST_F(HectorCompanions, TheMapComesAsImages) {
  sensor_msgs::Image full, tile;
  sensor_msgs::CompressedImage compressed;
  const auto store = [](auto& target) {
    using Message = std::decay_t<decltype(target)>;
    return boost::function<void(const boost::shared_ptr<const Message>&)>(
        [&target](const boost::shared_ptr<const Message>& message) { target = *message; });
  };
  const auto a = client_->nh.subscribe<sensor_msgs::Image>("map_image/full", 1, store(full));
  const auto b = client_->nh.subscribe<sensor_msgs::Image>("map_image/tile", 1, store(tile));
  const auto c = client_->nh.subscribe<sensor_msgs::CompressedImage>("map_image/full/compressed", 1,
                                                                     store(compressed));
  // The next map comes with the next scans.
  const TestFlight flight = laboratoryFlight(220);
  std::size_t next = 120;
  ASSERT_TRUE(client_->waitFor([&] {
    if (next < flight.scans.size()) {
      client_->match(messageOf(flight.scans[next++].scan, "base_link"));
    }
    return !full.data.empty() && !tile.data.empty() && !compressed.data.empty();
  }));
  EXPECT_EQ(full.data.size(), static_cast<std::size_t>(full.width) * full.height);
  EXPECT_EQ(tile.width, 64U);
  EXPECT_EQ(tile.encoding, "mono8");
  EXPECT_EQ(std::string(compressed.data.begin() + 1, compressed.data.begin() + 4), "PNG");
  EXPECT_LT(compressed.data.size(), full.data.size() / 4);
}

TEST_F(HectorCompanions, TheGeotiffIsWrittenByCommandAndService) {
  fs::remove_all("geotiff_of_test");
  std_srvs::Trigger service;
  ASSERT_TRUE(call("save_geotiff", service));
  ASSERT_TRUE(service.response.success) << service.response.message;
  const fs::path path = service.response.message;
  EXPECT_EQ(path.filename().string().find("RoboCup_team_"), 0U) << path;
  EXPECT_GT(fs::file_size(path), 1000U);
  fs::remove_all(path.parent_path());

  ros::Publisher command = client_->nh.advertise<std_msgs::String>("syscommand", 1);
  ASSERT_TRUE(client_->waitFor([&] { return command.getNumSubscribers() >= 2; }));
  std_msgs::String text;
  text.data = "savegeotiff";
  command.publish(text);
  EXPECT_TRUE(client_->waitFor([&] { return fs::exists(path.parent_path()); }));
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "hector_companions_live_test");
  return RUN_ALL_TESTS();
}
