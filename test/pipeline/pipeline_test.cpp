// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/pipeline.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

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
