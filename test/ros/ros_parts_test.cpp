// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <ros/ros.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <thread>
#include <vector>

#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/ros/common/bounded_queue.h"
#include "kestrel_slam/ros/common/fair_mutex.h"
#include "kestrel_slam/ros/mapper/graph_markers.h"
#include "kestrel_slam/ros/mapper/shared_mapper.h"
#include "kestrel_slam/ros/mapper/trajectory_log.h"
#include "kestrel_slam/ros/mapper/uncertainty_markers.h"
#include "mapper_client.h"

namespace kestrel {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(UncertaintyMarkers, ShowTheEllipseAndTheUnobservableDirection) {
  MapperResult result;
  result.pose = Pose2(3, 4, 1);
  result.covariance(0, 0) = 0.0001;
  result.covariance(1, 1) = 0.25;  // large variance along y
  result.match.degenerate_direction = {0.0, 1.0};
  EXPECT_EQ(uncertaintyMarkers(result).markers.at(1).action, visualization_msgs::Marker::DELETE);
  result.match.degenerate = true;
  const visualization_msgs::MarkerArray array = uncertaintyMarkers(result);
  const visualization_msgs::Marker &ellipse = array.markers.at(0), &line = array.markers.at(1);
  EXPECT_EQ(ellipse.pose.position.x, 3.0);
  EXPECT_NEAR(ellipse.scale.x, 3.0, 1e-9) << "three sigma on both sides";
  EXPECT_NEAR(ellipse.scale.y, 0.06, 1e-9);
  EXPECT_NEAR(std::abs(ellipse.pose.orientation.z), std::sqrt(0.5), 1e-9);
  EXPECT_EQ(line.action, visualization_msgs::Marker::ADD);
  ASSERT_EQ(line.points.size(), 2U);
  EXPECT_EQ(line.points[0].x, 3.0);
  EXPECT_EQ(line.points[1].y - line.points[0].y, 4.0);
}

TEST(GraphMarkers, PartsThatAreNotJoinedAreShownApart) {
  GraphView graph;
  graph.keyframes = {Pose2(0, 0, 0), Pose2(1, 0, 0), Pose2(9, 9, 0), Pose2(9, 8, 0)};
  graph.path = {{0, 1}, {2, 3}};
  graph.parts = {0, 0, 2, 2};
  const auto lines = [&](const std::string& ns) {
    std::vector<double> result;
    for (const visualization_msgs::Marker& marker : graphMarkers(graph, "map", {}).markers)
      for (const geometry_msgs::Point& point : marker.points)
        if (marker.ns == ns) result.push_back(point.x);
    return result;
  };
  EXPECT_EQ(lines("keyframes"), (std::vector<double>{9, 9}));
  EXPECT_EQ(lines("keyframes not joined"), (std::vector<double>{0, 1}));
  graph.parts = {0, 0, 0, 0};  // a loop joined them; nobody moved from 1 to 2
  EXPECT_EQ(lines("keyframes"), (std::vector<double>{0, 1, 9, 9}));
  EXPECT_TRUE(lines("keyframes not joined").empty());
}

TEST(BoundedQueue, DropsTheOldest) {
  BoundedQueue<int> queue(2);
  EXPECT_TRUE(queue.push(1));
  EXPECT_TRUE(queue.push(2));
  EXPECT_FALSE(queue.push(3));
  EXPECT_EQ(queue.pop(), 2);
  EXPECT_EQ(queue.pop(), 3);
  EXPECT_TRUE(queue.push(4));
  EXPECT_EQ(queue.clear(), 1U);
}

TEST(BoundedQueue, CloseWakesTheReader) {
  BoundedQueue<int> queue(1);
  std::thread closer([&] { queue.close(); });
  EXPECT_EQ(queue.pop(), std::nullopt);
  closer.join();
}

TEST(FairMutex, OtherThreadsGetTheLock) {
  FairMutex mutex;
  std::atomic<bool> started{false}, stop{false};
  std::thread greedy([&] {
    while (!stop) {
      const std::lock_guard<FairMutex> lock(mutex);
      started = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  });
  while (!started) std::this_thread::yield();
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 20; ++i) const std::lock_guard<FairMutex> lock(mutex);
  const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - start;
  stop = true;
  greedy.join();
  EXPECT_LT(waited.count(), 1.0) << "at most one lock of the other thread before each of ours";
}

/// Takes all changes. Returns the last part.
MapChanges refresh(SharedMapper& mapper, MapReplica& replica) {
  MapChanges changes;
  do {
    changes = mapper.takeChanges();
    for (const TileImage& tile : changes.tiles) replica.update(tile);
  } while (!changes.complete);
  return changes;
}

TEST(SharedMapper, CopiesWhileScansAreMatched) {
  SharedMapper mapper{MapperConfig()};
  const TestFlight flight = laboratoryFlight(60);
  std::atomic<bool> stop{false};
  MapReplica replica(0.05);
  std::thread reader([&] {
    while (!stop) {
      refresh(mapper, replica);
      mapper.restartMotion();
    }
  });
  for (const SimulatedScan& step : flight.scans) {
    PlanarScan scan;
    scan.stamp = scan.time = step.scan.stamp;
    for (std::size_t i = 0; i < step.scan.ranges.size(); ++i) {
      const double angle = step.scan.angle_min + static_cast<double>(i) * step.scan.angle_increment;
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      scan.rays.push_back(
          {Eigen::Vector2f::Zero(), step.scan.ranges[i] * direction.cast<float>(), true});
    }
    EXPECT_TRUE(mapper.process(scan, std::nullopt, ros::Time(scan.stamp)).pose.isFinite());
  }
  stop = true;
  reader.join();
  EXPECT_GT(mapper.version(), 0U);
  const MapChanges last = refresh(mapper, replica);
  EXPECT_EQ(last.stamp, ros::Time(flight.scans.back().scan.stamp));
  EXPECT_GT(replica.known().x1 - replica.known().x0, 100);
  mapper.reset(Pose2());
  const MapChanges after = mapper.takeChanges();
  EXPECT_NE(after.map_number, last.map_number);
  EXPECT_TRUE(after.complete && after.tiles.empty());
}

TEST(TrajectoryLog, IsThinnedOutAndLimited) {
  TrajectoryLog log;
  log.add(ros::Time(1.0), Pose2());
  log.add(ros::Time(2.0), Pose2(0.01, 0.0, 0.01));  // too close to the last pose
  log.add(ros::Time(3.0), Pose2(0.06, 0.0, 0.0));
  log.add(ros::Time(4.0), Pose2(0.06, 0.0, 0.2));
  const nav_msgs::Path path = log.path("map");
  ASSERT_EQ(path.poses.size(), 3U);
  EXPECT_EQ(path.poses[1].header.stamp, ros::Time(3.0));
  EXPECT_EQ(path.header.stamp, ros::Time(4.0));
  for (std::size_t i = 0; i < 3 * TrajectoryLog::kMaxPoses; ++i) {
    log.add(ros::Time(5.0), Pose2(static_cast<double>(i), 0.0, 0.0));
  }
  EXPECT_LE(log.path("map").poses.size(), TrajectoryLog::kMaxPoses);
  log.clear();
  EXPECT_TRUE(log.path("map").poses.empty());
}

/// 5 km in steps of 5 cm: the first meters are drawn as exactly as the last ones.
TEST(TrajectoryLog, IsThinnedOutEvenly) {
  TrajectoryLog log;
  for (int i = 0; i < 100000; ++i) log.add(ros::Time(5.0), Pose2(0.0501 * i, 0.0, 0.0));
  const nav_msgs::Path path = log.path("map");
  ASSERT_GT(path.poses.size(), TrajectoryLog::kMaxPoses / 2);
  double shortest = 1e9, longest = 0.0;
  for (std::size_t i = 1; i < path.poses.size(); ++i) {
    const double step = path.poses[i].pose.position.x - path.poses[i - 1].pose.position.x;
    shortest = std::min(shortest, step);
    longest = std::max(longest, step);
  }
  EXPECT_LT(longest, 2.1 * shortest);
}

TEST(Conversions, CovarianceIsPositiveDefiniteForAnyInput) {
  Eigen::Matrix3d singular = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d negative = -Eigen::Matrix3d::Identity();
  Eigen::Matrix3d infinite = Eigen::Matrix3d::Constant(std::numeric_limits<double>::infinity());
  for (const Eigen::Matrix3d& covariance : {singular, negative, infinite}) {
    const geometry_msgs::PoseWithCovariance message = toMessage(Pose2(), covariance);
    Eigen::Matrix<double, 6, 6> full;
    for (int i = 0; i < 36; ++i) {
      full(i / 6, i % 6) = message.covariance[static_cast<std::size_t>(i)];
    }
    EXPECT_EQ(full, full.transpose());
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(full);
    EXPECT_GT(solver.eigenvalues().minCoeff(), 0.0);
  }
}

TEST(Conversions, CovarianceElementsKeepTheirIndices) {
  Eigen::Matrix3d covariance;
  covariance << 4.0, 1.0, 0.5, 1.0, 3.0, 0.25, 0.5, 0.25, 2.0;
  const auto full = toMessage(Pose2(), covariance).covariance;
  EXPECT_NEAR(full[0], 4.0, 1e-12);
  EXPECT_NEAR(full[1], 1.0, 1e-12);
  EXPECT_NEAR(full[5], 0.5, 1e-12);
  EXPECT_NEAR(full[7], 3.0, 1e-12);
  EXPECT_NEAR(full[11], 0.25, 1e-12);
  EXPECT_NEAR(full[35], 2.0, 1e-12);
}

TEST(Conversions, PoseRoundTrip) {
  const Pose2 pose(1.5, -2.5, 3.0);
  const Pose2 back = planarFromMessage(toMessage(pose));
  EXPECT_DOUBLE_EQ(back.x, pose.x);
  EXPECT_DOUBLE_EQ(back.y, pose.y);
  EXPECT_NEAR(back.yaw, pose.yaw, 1e-12);
}

TEST(Conversions, InvalidPosesAreRefused) {
  geometry_msgs::Pose pose;  // the quaternion of an empty message is zero
  EXPECT_THROW(planarFromMessage(pose), std::invalid_argument);
  pose.orientation.w = 1.0;
  EXPECT_NO_THROW(planarFromMessage(pose));
  pose.position.z = kNan;
  EXPECT_THROW(planarFromMessage(pose), std::invalid_argument);
}

TEST(Conversions, MapKeepsCellsAndOrigin) {
  MapSnapshot map;
  map.resolution_m = 0.25;
  map.origin_x = -1.0;
  map.origin_y = 2.0;
  map.width = 3;
  map.height = 2;
  map.cells = {-1, 0, 100, 0, 0, -1};
  const nav_msgs::OccupancyGrid message = toMessage(map);
  EXPECT_EQ(message.data, map.cells);
  EXPECT_EQ(message.info.width, 3U);
  EXPECT_EQ(message.info.height, 2U);
  EXPECT_EQ(message.info.resolution, 0.25F);
  EXPECT_EQ(message.info.origin.position.x, -1.0);
  EXPECT_EQ(message.info.origin.position.y, 2.0);
  EXPECT_EQ(message.info.origin.orientation.w, 1.0);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::Time::init();
  return RUN_ALL_TESTS();
}
