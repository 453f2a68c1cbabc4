// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/pipeline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "graph/loop_world.h"
#include "room_log.h"

namespace kestrel {
namespace {

/// A pipeline that is fed with the flight through a room.
class RoomPipeline {
 public:
  explicit RoomPipeline(const PipelineConfig& config) : pipeline(config) {
    pipeline.on_scan = [this](const MappedSweep& sweep) { results.push_back(sweep.result); };
    pipeline.on_drop = [this](const DroppedSweep& sweep) { reasons.push_back(sweep.reason); };
  }

  void fly(int from, int to) {
    for (int i = from; i < to; ++i) {
      PipelineScan scan;
      const LaserScan sweep = RoomFlight::scan(i);
      scan.data = sweep;
      pipeline.addScan(scan, sweep.stamp);
    }
  }

  Pipeline pipeline;
  std::vector<MapperResult> results;
  std::vector<std::string> reasons;
};

PipelineConfig levelConfig() {
  PipelineConfig config;
  config.level = true;
  return config;
}

void expectNear(const Pose2& actual, const Pose2& expected) {
  EXPECT_LT((expected.inverse() * actual).distance(), 0.03);
  EXPECT_NEAR(normalizeAngle(actual.yaw - expected.yaw), 0.0, 0.01);
}

TEST(Pipeline, ALevelLaserNeedsNoImu) {
  RoomPipeline room(levelConfig());
  room.fly(0, 20);
  ASSERT_EQ(room.results.size(), 20U);
  EXPECT_TRUE(room.reasons.empty());
  expectNear(room.results.back().pose, Pose2(RoomFlight::x(19) - RoomFlight::x(0), 0.0, 0.0));
}

TEST(Pipeline, ResetStartsANewMapAtThePose) {
  RoomPipeline room(levelConfig());
  room.fly(0, 10);
  const Pose2 start(5.0, 1.0, 0.5);
  room.pipeline.reset(start);
  room.fly(10, 20);
  expectNear(room.results[10].pose, start);
  expectNear(room.results.back().pose,
             start * Pose2(RoomFlight::x(19) - RoomFlight::x(10), 0.0, 0.0));
}

TEST(Pipeline, AnInitialPoseKeepsTheMap) {
  RoomPipeline room(levelConfig());
  room.fly(0, 10);
  room.pipeline.setPose(Pose2(RoomFlight::x(10) + 0.2, 0.1, 0.05), Eigen::Matrix3d::Identity());
  room.fly(10, 11);
  expectNear(room.results.back().pose, Pose2(RoomFlight::x(10) - RoomFlight::x(0), 0.0, 0.0));
}

TEST(Pipeline, WithoutImuScansAreDroppedWithTheReason) {
  RoomPipeline room{PipelineConfig()};
  room.fly(0, 3);
  room.pipeline.finish();
  EXPECT_TRUE(room.results.empty());
  EXPECT_EQ(room.reasons, std::vector<std::string>(3, "no-imu"));
}

/// A store with boxes in irregular places, but not on the path of loop_world::laps().
std::vector<room::Segment> storeWalls() {
  std::vector<room::Segment> walls;
  loop_world::addBox(walls, -20, -20, 40, 40);
  std::uint32_t random = 1;
  const auto next = [&random](double most) {
    random = random * 1664525U + 1013904223U;
    return most * static_cast<double>(random >> 8U) / static_cast<double>(1U << 24U);
  };
  while (walls.size() < 300) {
    const double x = next(38.0) - 19.0, y = next(38.0) - 19.0;
    const auto is_free = [](double at) { return std::abs(std::abs(at + 0.5) - 10.5) > 1.5; };
    if (is_free(x) && is_free(y)) loop_world::addBox(walls, x, y, 0.2 + next(0.8), 0.2 + next(0.8));
  }
  return walls;
}

LaserScan scanFrom(const Pose2& pose, double stamp) {
  static const std::vector<room::Segment> kStore = storeWalls();
  constexpr std::size_t kBeams = 360;
  LaserScan scan;
  scan.stamp = stamp;
  scan.angle_min = -kPi;
  scan.angle_increment = 2.0 * kPi / kBeams;
  scan.range_min = 0.05;
  scan.range_max = 8.0;
  for (std::size_t i = 0; i < kBeams; ++i) {
    const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    const double range = room::cast(kStore, pose, angle);
    scan.ranges.push_back(range < scan.range_max ? static_cast<float>(range)
                                                 : std::numeric_limits<float>::infinity());
  }
  return scan;
}

/// Somebody carries the vehicle to a place that it knows, but not near its last pose: it says that
/// it is lost, begins a new map, and finds its place in the old one.
TEST(Pipeline, ACarriedVehicleIsFoundInTheOldMap) {
  RoomPipeline store(levelConfig());
  std::vector<Pose2> path = loop_world::laps(1.0);
  const std::size_t carried = path.size();
  path.insert(path.end(), path.begin() + 110, path.begin() + 330);
  for (std::size_t i = 0; i < path.size(); ++i) {
    PipelineScan scan;
    scan.data = scanFrom(path[i], 0.1 * static_cast<double>(i));
    store.pipeline.addScan(scan, 0.1 * static_cast<double>(i));
  }
  store.pipeline.finish();
  const SubmapGraph& graph = *store.pipeline.graph();
  EXPECT_EQ(graph.partCount(), 1U) << "both flights are one map";
  ASSERT_EQ(store.results.size(), path.size());
  EXPECT_EQ(store.results.back().state, MatchState::kOk);
  const Pose2 truth = path.front().between(path.back());
  EXPECT_LT(truth.between(graph.mapTLocal() * store.results.back().pose).distance(), 0.1);
  std::size_t unlocated = 0;
  for (std::size_t i = carried + 2; i < path.size(); ++i) {
    const std::string& reason = store.results[i].reason;
    unlocated += reason == "place unknown" ? 1U : 0U;
    if (graph.keyframes().empty() || store.results[i].state != MatchState::kOk) continue;
    EXPECT_GT(unlocated, 0U) << "scan " << i << " is ok at a wrong place";
  }
  EXPECT_GT(unlocated, 0U);
}

TEST(MatchedPose, OfALostMapperIsNotFused) {
  PoseFilter filter;
  MatchedPose pose;
  pose.covariance = 1e-4 * Eigen::Matrix3d::Identity();
  pose.state = MatchState::kLost;
  EXPECT_FALSE(fuse(pose, filter));
  EXPECT_EQ(filter.status(0.0).of(FilterSensor::kPose).received, 0U);
  pose.state = MatchState::kDegraded;
  fuse(pose, filter);
  EXPECT_EQ(filter.status(0.0).of(FilterSensor::kPose).received, 1U);
}

TEST(MatchedPose, KeepsTheUnobservableDirection) {
  MapperResult result;
  EXPECT_TRUE(matchedPoseOf(result, 1.0).unobservable.isZero());
  result.match.degenerate = true;
  result.match.degenerate_direction = Eigen::Vector2d(0.6, 0.8);
  EXPECT_EQ(matchedPoseOf(result, 1.0).unobservable, result.match.degenerate_direction);
}

TEST(Pipeline, ALaserThatTiltsInTfIsSaidOnce) {
  RoomPipeline room(levelConfig());
  std::vector<std::string> problems;
  room.pipeline.on_problem = [&](const ImuFault& problem, double) {
    problems.push_back(problem.message);
  };
  for (int i = 0; i < 20; ++i) {
    PipelineScan scan;
    scan.data = RoomFlight::scan(i);
    scan.base_T_laser = Eigen::AngleAxisd(0.01 * i, Eigen::Vector3d::UnitY());
    room.pipeline.addScan(scan, RoomFlight::stamp(i));
  }
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_NE(problems[0].find("mav.launch"), std::string::npos);
}

}  // namespace
}  // namespace kestrel
