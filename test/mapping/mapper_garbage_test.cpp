// SPDX-License-Identifier: BSD-3-Clause
// Feeds invalid and extreme numbers to the mapper: it must not crash, hang or return NaN.

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "kestrel_slam/mapping/mapper.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A pose without wrapping the yaw, which the constructor would do.
Pose2 poseOf(double x, double y, double yaw) {
  Pose2 pose;
  pose.x = x;
  pose.y = y;
  pose.yaw = yaw;
  return pose;
}

void expectFiniteAndInRange(const MapperResult& result) {
  ASSERT_TRUE(result.pose.isFinite());
  ASSERT_TRUE(result.match.pose.isFinite());
  ASSERT_TRUE(result.covariance.allFinite());
  ASSERT_TRUE(result.match.degenerate_direction.allFinite());
  ASSERT_TRUE(result.match.score >= 0.0 && result.match.score <= 1.0 + 1e-6);
  ASSERT_TRUE(result.match.known >= 0.0 && result.match.known <= 1.0);
  ASSERT_FALSE(std::isnan(result.evaluation));
  for (const StageEstimate& stage : result.match.stages) {
    ASSERT_TRUE(stage.pose.isFinite() && std::isfinite(stage.score));
  }
}

/// Points in free space: a scan that does not fit anywhere.
PlanarScan unmatchableScan() {
  PlanarScan scan;
  for (int i = 0; i < 90; ++i) {
    const auto angle = static_cast<float>(i) * 0.07F;
    scan.rays.push_back({Eigen::Vector2f::Zero(), {std::cos(angle), std::sin(angle)}, true});
  }
  return scan;
}

class MapperGarbage : public ::testing::TestWithParam<std::string> {
 protected:
  MapperConfig config() const {
    MapperConfig config;
    config.matcher.method = GetParam();
    return config;
  }

  Mapper inRoom() const {
    Mapper mapper(config());
    mapper.process(room::scanFrom(Pose2()));
    return mapper;
  }
};

TEST_P(MapperGarbage, BrokenOdometryNeverReachesThePose) {
  Mapper mapper = inRoom();
  const std::vector<Pose2> broken = {
      poseOf(kNan, 0, 0), poseOf(0, kInfinity, 0), poseOf(0, 0, kNan), poseOf(0, 0, -kInfinity),
      poseOf(1e9, 0, 0),  poseOf(0, -1e300, 0),    poseOf(0, 0, 1e300)};
  for (const Pose2& odom : broken) {
    // While lost, the pose follows the odometry, which is invalid here.
    ASSERT_NO_FATAL_FAILURE(
        expectFiniteAndInRange(mapper.process(unmatchableScan(), Pose2(1, 2, 3))));
    ASSERT_NO_FATAL_FAILURE(expectFiniteAndInRange(mapper.process(unmatchableScan(), odom)));
    ASSERT_NO_FATAL_FAILURE(
        expectFiniteAndInRange(mapper.process(unmatchableScan(), Pose2(1, 2, 3))));
    EXPECT_LT(mapper.pose().distance(), 5.0);
  }
}

TEST_P(MapperGarbage, BrokenPosesAreIgnored) {
  Mapper mapper = inRoom();
  const Pose2 before = mapper.pose();
  const MapSnapshot map = mapper.snapshot();
  for (const double value : {kNan, kInfinity, -kInfinity, 1e9, -1e9, 1e300}) {
    for (const Pose2& pose : {poseOf(value, 0, 0), poseOf(0, value, 0)}) {
      mapper.setPose(pose);
      EXPECT_EQ(mapper.pose(), before) << value;
      mapper.reset(pose);
      EXPECT_EQ(mapper.snapshot().cells, map.cells) << value;
    }
  }
  mapper.setPose(poseOf(0, 0, kNan));
  EXPECT_EQ(mapper.pose(), before);
  EXPECT_TRUE(mapper.process(room::scanFrom(Pose2(0.02, 0.01, 0))).isMatched());
}

TEST_P(MapperGarbage, SetPoseFarAwayAndBackIsHandled) {
  Mapper mapper = inRoom();
  for (const double far : {1e3, 1e5, -9e5}) {
    mapper.setPose(Pose2(far, -far, 1.0));
    const MapperResult result = mapper.process(room::scanFrom(Pose2()));
    ASSERT_NO_FATAL_FAILURE(expectFiniteAndInRange(result));
    EXPECT_EQ(result.state, MatchState::kLost);
    EXPECT_FALSE(result.inserted);
  }
  mapper.setPose(Pose2(0.1, 0.0, 0.05));
  const MapperResult back = mapper.process(room::scanFrom(Pose2(0.02, 0.01, 0)));
  EXPECT_EQ(back.state, MatchState::kOk);
  // Votes cannot resolve the position of a wall within its cell, and the walls of the room are
  // parallel to the cells.
  EXPECT_NEAR(back.pose.x, 0.02, GetParam() == "progressive" ? 0.05 : 0.03);
}

TEST_P(MapperGarbage, BrokenRaysAreIgnoredAndTheOthersUsed) {
  Mapper clean = inRoom(), broken = inRoom();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity(), huge = 3e38F;
  const PlanarScan scan = room::scanFrom(Pose2(0.25, 0.1, 0.1));
  PlanarScan broken_scan = scan;
  for (const float value : {nan, infinity, -infinity, huge, -huge, 1e9F}) {
    for (const bool hit : {true, false}) {
      broken_scan.rays.push_back({Eigen::Vector2f::Zero(), {value, 0.5F}, hit});
      broken_scan.rays.push_back({Eigen::Vector2f::Zero(), {0.5F, value}, hit});
      broken_scan.rays.push_back({{value, 0.0F}, {1.0F, 1.0F}, hit});
      broken_scan.rays.push_back({{0.0F, value}, {1.0F, 1.0F}, hit});
      broken_scan.rays.push_back({{value, value}, {value, value}, hit});
    }
  }
  const MapperResult expected = clean.process(scan), result = broken.process(broken_scan);
  EXPECT_EQ(result.pose, expected.pose);
  EXPECT_EQ(result.inserted, expected.inserted);
  EXPECT_EQ(broken.snapshot().cells, clean.snapshot().cells);
}

TEST_P(MapperGarbage, AFirstScanOfBrokenRaysDoesNotStartAMap) {
  Mapper mapper(config());
  PlanarScan scan;
  scan.rays.push_back({Eigen::Vector2f::Zero(), {1e9F, std::nanf("")}, true});
  const MapperResult result = mapper.process(scan);
  ASSERT_NO_FATAL_FAILURE(expectFiniteAndInRange(result));
  EXPECT_FALSE(result.inserted);
  EXPECT_TRUE(mapper.snapshot().empty());
  EXPECT_TRUE(mapper.process(room::scanFrom(Pose2())).inserted);
}

TEST_P(MapperGarbage, VeryLongRaysNeitherHangNorExhaustMemory) {
  Mapper mapper = inRoom();
  PlanarScan scan = unmatchableScan();
  for (const float range : {150.0F, 999.0F, 6000.0F, -6000.0F}) {
    scan.rays.push_back({Eigen::Vector2f::Zero(), {range, 0.3F * range}, true});
  }
  const auto start = std::chrono::steady_clock::now();
  ASSERT_NO_FATAL_FAILURE(expectFiniteAndInRange(mapper.process(scan)));
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_LT(seconds.count(), 10.0);
  EXPECT_LT(mapper.memoryBytes(), 100000000U);
}

TEST_P(MapperGarbage, InvalidTimesDoNotMakeTheMatchFail) {
  Mapper mapper = inRoom();
  PlanarScan scan = room::scanFrom(Pose2());
  for (const double time : {kNan, kInfinity, -kInfinity, -1e300, 0.0, 1e300, 5.0}) {
    scan.time = scan.stamp = time;
    const MapperResult result = mapper.process(scan);
    ASSERT_NO_FATAL_FAILURE(expectFiniteAndInRange(result));
    EXPECT_EQ(result.state, MatchState::kOk) << time;
  }
}

TEST_P(MapperGarbage, HandlesOnePointAndEmptyWindows) {
  MapperConfig tight = config();
  tight.matcher.near_window = tight.matcher.wide_window = {0.0, 0.0};
  Mapper mapper(tight);
  PlanarScan one;
  one.rays.push_back({Eigen::Vector2f::Zero(), {1.0F, 0.0F}, true});
  for (int i = 0; i < 5; ++i) ASSERT_NO_FATAL_FAILURE(expectFiniteAndInRange(mapper.process(one)));
  ASSERT_NO_FATAL_FAILURE(expectFiniteAndInRange(mapper.process(unmatchableScan())));
  ASSERT_NO_FATAL_FAILURE(expectFiniteAndInRange(mapper.process(PlanarScan())));
}

/// A float of 32 arbitrary bits; in half of the cases a plausible coordinate.
float anyFloat(std::mt19937_64& random) {
  const auto bits = static_cast<std::uint32_t>(random());
  if (bits % 2 == 0) return static_cast<float>(bits % 16000) * 1e-3F - 8.0F;
  float value = 0.0F;
  std::memcpy(&value, &bits, sizeof value);
  // Longer rays are tested above, and thousands of them take too long.
  return std::abs(value) < 50.0F || !(std::abs(value) < 1e4F) ? value : 1.0F;
}

TEST_P(MapperGarbage, AThousandScansOfArbitraryBits) {
  MapperConfig quick = config();
  quick.matcher.near_window = quick.matcher.wide_window = {0.1, 0.1};
  quick.grid.memory_limit_mb = 0.3;
  quick.lost_score = quick.min_known_share = 0.0;  // so that the garbage is inserted
  quick.evaluation.enabled = false;
  Mapper mapper(quick);
  std::mt19937_64 random(2024);
  std::uniform_real_distribution<double> anything(-1e3, 1e3);
  bool full = false;
  for (int i = 0; i < 1000; ++i) {
    PlanarScan scan;
    scan.time = i % 11 == 0 ? kNan : 0.1 * i;
    scan.rays.resize(random() % 120);
    for (PlanarRay& ray : scan.rays) {
      ray = {{anyFloat(random), 0.0F}, {anyFloat(random), anyFloat(random)}, random() % 2 == 0};
    }
    std::optional<Pose2> odom;
    if (i % 3 == 0) odom = Pose2(anything(random), anything(random), anything(random));
    if (i % 17 == 0) odom = poseOf(static_cast<double>(anyFloat(random)), kNan, 0.0);
    if (i % 50 == 0) mapper.setPose(Pose2(0.01 * anything(random), 0.0, anything(random)));
    if (i % 250 == 0) mapper.reset(Pose2(anything(random), anything(random), 0.0));
    const MapperResult result = mapper.process(scan, odom);
    ASSERT_NO_FATAL_FAILURE(expectFiniteAndInRange(result)) << "scan " << i;
    ASSERT_EQ(result.pose, mapper.pose());
    full |= result.map_full;
  }
  EXPECT_LT(mapper.memoryBytes(), 3000000U);
  EXPECT_TRUE(full);
}

INSTANTIATE_TEST_SUITE_P(Methods, MapperGarbage,
                         ::testing::Values("gauss_newton", "correlative", "progressive", "icp",
                                           "hybrid"));

}  // namespace
}  // namespace kestrel
