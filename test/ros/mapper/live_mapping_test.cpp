// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <map_msgs/OccupancyGridUpdate.h>
#include <nav_msgs/GetMap.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "kestrel_slam/messages/conversions.h"
#include "mapper_client.h"

namespace kestrel {
namespace {

constexpr std::size_t kScans = 400;  // 40 s, most of the loop

/// The map as a client sees it that also uses map_updates.
struct UpdatedMap {
  nav_msgs::OccupancyGrid map;
  std::size_t updates = 0, outside = 0;
  ros::Subscriber map_subscriber, update_subscriber;

  UpdatedMap() {
    ros::NodeHandle nh;
    const boost::function<void(const nav_msgs::OccupancyGrid&)> replace =
        [this](const nav_msgs::OccupancyGrid& whole) { map = whole; };
    const boost::function<void(const map_msgs::OccupancyGridUpdate&)> apply =
        [this](const map_msgs::OccupancyGridUpdate& update) { add(update); };
    map_subscriber = nh.subscribe<nav_msgs::OccupancyGrid>("map", 10, replace);
    update_subscriber = nh.subscribe<map_msgs::OccupancyGridUpdate>("map_updates", 10, apply);
  }

  void add(const map_msgs::OccupancyGridUpdate& update) {
    ++updates;
    if (update.x < 0 || update.y < 0 || update.x + update.width > map.info.width ||
        update.y + update.height > map.info.height) {
      ++outside;
      return;
    }
    for (std::size_t row = 0; row < update.height; ++row) {
      const auto from = update.data.begin() + static_cast<std::ptrdiff_t>(row * update.width);
      const std::size_t to = (static_cast<std::size_t>(update.y) + row) * map.info.width +
                             static_cast<std::size_t>(update.x);
      std::copy(from, from + update.width, map.data.begin() + static_cast<std::ptrdiff_t>(to));
    }
  }
};

/// One flight, mapped by the node that the .test file starts. Every test checks one part of the
/// result.
class LiveMapping : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    client_ = new MapperClient;
    updated_ = new UpdatedMap;
    flight_ = new TestFlight(laboratoryFlight(kScans));
    ASSERT_TRUE(client_->connect()) << "the mapper does not subscribe to scan";
    const Pose2 base_T_laser;  // the simulated laser is at the origin of the base
    client_->static_broadcaster.sendTransform(
        transformOf("base_link", "laser", base_T_laser, ros::Time::now()));
    for (const SimulatedScan& step : flight_->scans) {
      const auto pose = client_->match(messageOf(step.scan, "laser"));
      ASSERT_TRUE(pose) << "no pose for scan " << poses_.size();
      poses_.push_back(*pose);
      if (poses_.size() > kScans / 2 && updated_->updates == 0) waitAsLongAsALaser();
    }
    nav_msgs::GetMap newest;
    ASSERT_TRUE(ros::service::call("dynamic_map", newest));
    ASSERT_TRUE(client_->waitFor([&] { return client_->map.data == newest.response.map.data; }))
        << "the newest map was not published";
  }
  static void TearDownTestSuite() {
    delete updated_;
    delete client_;
    delete flight_;
  }

  /// Updates come by wall time and only while the map does not grow: a fast machine would be
  /// through with the flight before the first one.
  static void waitAsLongAsALaser() {
    ros::WallDuration(0.1).sleep();
    ros::spinOnce();
  }

  static const SimulatedScan& lastScan() { return flight_->scans.back(); }

  static Eigen::Vector2d inWorld(const Eigen::Vector2d& in_map) {
    return flight_->scans.front().world_T_base * in_map;
  }

  inline static MapperClient* client_ = nullptr;
  inline static UpdatedMap* updated_ = nullptr;
  inline static TestFlight* flight_ = nullptr;
  inline static std::vector<Pose2> poses_;
};

TEST_F(LiveMapping, PosesMatchTheTruth) {
  double worst_m = 0.0, worst_rad = 0.0;
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const Pose2 error = flight_->truth(i).inverse() * poses_[i];
    worst_m = std::max(worst_m, error.distance());
    worst_rad = std::max(worst_rad, std::abs(error.yaw));
  }
  EXPECT_LT(worst_m, 0.05);
  EXPECT_LT(worst_rad, 0.01);
  EXPECT_GT(flight_->truth(kScans - 1).distance(), 1.0) << "the vehicle must move";
}

TEST_F(LiveMapping, StampsAndFramesMatchTheScans) {
  const ros::Time stamp(lastScan().scan.stamp);
  EXPECT_EQ(client_->pose.header.stamp, stamp);
  EXPECT_EQ(client_->pose.header.frame_id, "map");
  EXPECT_EQ(client_->pose_update.header.stamp, stamp);
  EXPECT_EQ(client_->pose_update.header.frame_id, "map");
  EXPECT_EQ(client_->map.header.frame_id, "map");
}

TEST_F(LiveMapping, TfHasOneParentAndEqualsThePose) {
  ASSERT_TRUE(client_->waitFor([] {
    return client_->lastTransform("base_link").header.stamp == ros::Time(lastScan().scan.stamp);
  }));
  const std::set<std::string> map{"map"};
  EXPECT_EQ(client_->parents["base_link"], map);
  EXPECT_EQ(client_->parents["scanmatcher_frame"], map);
  EXPECT_EQ(client_->parents.count("odom"), 0U);
  EXPECT_TRUE(poseOf(client_->lastTransform("base_link").transform) == poses_.back());
  EXPECT_TRUE(poseOf(client_->lastTransform("scanmatcher_frame").transform) == poses_.back());
}

TEST_F(LiveMapping, CovarianceIsPositiveDefinite) {
  Eigen::Matrix<double, 6, 6> covariance;
  for (int i = 0; i < 36; ++i) {
    covariance(i / 6, i % 6) = client_->pose_update.pose.covariance[static_cast<std::size_t>(i)];
  }
  EXPECT_EQ(covariance, covariance.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(covariance);
  EXPECT_GT(solver.eigenvalues().minCoeff(), 0.0);
  EXPECT_LT(covariance(0, 0), 0.01) << "m²; a room constrains x";
  EXPECT_LT(covariance(5, 5), 0.01) << "rad²; a room constrains the yaw";
  EXPECT_EQ(covariance(2, 2), kUnmeasuredHeightVariance);
  EXPECT_EQ(covariance(3, 3), kUnmeasuredTiltVariance);
}

TEST_F(LiveMapping, MapShowsTheRoom) {
  const nav_msgs::OccupancyGrid& map = client_->map;
  ASSERT_EQ(map.data.size(), map.info.width * map.info.height);
  std::size_t occupied = 0, at_a_wall = 0, other_values = 0;
  for (std::size_t i = 0; i < map.data.size(); ++i) {
    other_values += map.data[i] != -1 && map.data[i] != 0 && map.data[i] != 100 ? 1U : 0U;
    if (map.data[i] != 100) continue;
    const double column = static_cast<double>(i % map.info.width) + 0.5;
    const double row = static_cast<double>(i / map.info.width) + 0.5;
    const Eigen::Vector2d cell(map.info.origin.position.x + column * map.info.resolution,
                               map.info.origin.position.y + row * map.info.resolution);
    ++occupied;
    at_a_wall += flight_->distanceToSurface(inWorld(cell)) < 0.1 ? 1U : 0U;
  }
  EXPECT_EQ(other_values, 0U);
  EXPECT_GT(occupied, 500U);
  EXPECT_GT(at_a_wall, 0.98 * static_cast<double>(occupied));
}

TEST_F(LiveMapping, UpdatesKeepAMapUpToDate) {
  EXPECT_GT(updated_->updates, 0U);
  EXPECT_EQ(updated_->outside, 0U);
  EXPECT_TRUE(client_->waitFor([&] { return updated_->map.data == client_->map.data; }));
}

TEST_F(LiveMapping, PathIsFreeInTheMap) {
  const nav_msgs::OccupancyGrid& map = client_->map;
  for (std::size_t i = 0; i < kScans; i += 20) {
    const Pose2 pose = flight_->truth(i);
    const auto column = static_cast<std::size_t>((pose.x - map.info.origin.position.x) /
                                                 static_cast<double>(map.info.resolution));
    const auto row = static_cast<std::size_t>((pose.y - map.info.origin.position.y) /
                                              static_cast<double>(map.info.resolution));
    ASSERT_LT(column, map.info.width);
    EXPECT_EQ(map.data[row * map.info.width + column], 0) << "at scan " << i;
  }
}

TEST_F(LiveMapping, MetadataBelongsToTheMap) {
  ASSERT_TRUE(client_->waitFor([] { return client_->metadata == client_->map.info; }));
  EXPECT_FLOAT_EQ(client_->metadata.resolution, 0.05F);
}

TEST_F(LiveMapping, MapServiceGivesAMapOfTheLastScan) {
  nav_msgs::GetMap service;
  ASSERT_TRUE(ros::service::call("dynamic_map", service));
  EXPECT_EQ(service.response.map.header.stamp, ros::Time(lastScan().scan.stamp));
  EXPECT_EQ(service.response.map.data.size(),
            service.response.map.info.width * service.response.map.info.height);
}

TEST_F(LiveMapping, MatchedScanLiesOnTheWalls) {
  ASSERT_TRUE(client_->waitFor(
      [] { return client_->cloud.header.stamp == ros::Time(lastScan().scan.stamp); }));
  EXPECT_EQ(client_->cloud.header.frame_id, "map");
  sensor_msgs::PointCloud2ConstIterator<float> x(client_->cloud, "x"), y(client_->cloud, "y");
  std::size_t points = 0;
  for (; x != x.end(); ++x, ++y, ++points) {
    const Eigen::Vector2d point(static_cast<double>(*x), static_cast<double>(*y));
    EXPECT_LT(flight_->distanceToSurface(inWorld(point)), 0.15);
  }
  EXPECT_GT(points, 300U);
}

TEST_F(LiveMapping, TrajectoryFollowsThePath) {
  ASSERT_TRUE(client_->waitFor([] {
    return !client_->trajectory.poses.empty() &&
           (poseOf(client_->trajectory.poses.back().pose).inverse() * poses_.back()).distance() <
               0.1;
  }));
  EXPECT_LT(client_->trajectory.poses.size(), kScans) << "the trajectory must be thinned out";
  EXPECT_GT(client_->trajectory.poses.size(), 50U);
  EXPECT_EQ(client_->trajectory.header.frame_id, "map");
}

TEST_F(LiveMapping, DiagnosticsCountTheScans) {
  auto scans = client_->report("Scans"), match = client_->report("Match");
  auto map = client_->report("Map");
  EXPECT_EQ(scans["received"], std::to_string(kScans));
  EXPECT_EQ(scans["used"], std::to_string(kScans));
  EXPECT_EQ(match["state"], "ok");
  EXPECT_EQ(match["level"], "0");
  EXPECT_GT(std::stod(match["score"]), 0.5);
  EXPECT_NEAR(std::stod(map["width (m)"]), 8.0, 4.0);
  EXPECT_GT(std::stod(map["memory (MB)"]), 0.01);
}

TEST_F(LiveMapping, DiagnosticsWarnAboutASilentLaser) {
  ASSERT_TRUE(client_->waitFor([] { return client_->diagnosis("Scans", "level") == "1"; }));
  EXPECT_NE(client_->diagnosis("Scans", "message").find("no scan on /scan"), std::string::npos);
}

/// A subscriber gets the present probabilities at once, in the geometry of the map.
TEST_F(LiveMapping, ProbabilityMapAgreesWithTheMap) {
  nav_msgs::OccupancyGrid probabilities;
  const boost::function<void(const nav_msgs::OccupancyGrid&)> keep =
      [&](const nav_msgs::OccupancyGrid& message) { probabilities = message; };
  const ros::Subscriber subscriber =
      client_->nh.subscribe<nav_msgs::OccupancyGrid>("probability_map", 1, keep);
  ASSERT_TRUE(client_->waitFor([&] { return !probabilities.data.empty(); }));
  const nav_msgs::OccupancyGrid& map = client_->map;
  ASSERT_EQ(probabilities.data.size(), map.data.size());
  EXPECT_EQ(probabilities.info.origin.position.x, map.info.origin.position.x);
  std::set<int> values;
  for (std::size_t i = 0; i < map.data.size(); ++i) {
    const int p = probabilities.data[i];
    values.insert(p);
    ASSERT_EQ(map.data[i], p < 0 ? -1 : p > 50 ? 100 : 0) << "probability " << p;
  }
  EXPECT_GT(values.size(), 10U);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_mapping_test");
  return RUN_ALL_TESTS();
}
