// SPDX-License-Identifier: BSD-3-Clause
// Sketches: many hypotheses are compared with little work, and the right one stays.

#include "../../src/matching/sketch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "../../src/matching/surfel_lanes.h"
#include "kestrel_slam/map/tile_map.h"
#include "kestrel_slam/matching/thinned.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr std::int64_t kSketchWork = 1'000'000'000;
const Pose2 kSketchTruth(0.3, -0.2, 0.4);

Points sampleAt(const Pose2& pose) { return sampled(hitsOf(room::scanFrom(pose)), kSketchPoints); }

/// `count` poses; only the one with index `right` is near the truth.
std::vector<Pose2> hypotheses(int count, int right) {
  std::vector<Pose2> poses;
  for (int i = 0; i < count; ++i) {
    const double yaw = kSketchTruth.yaw + 0.7 + 0.15 * i;
    poses.emplace_back(kSketchTruth.x + 0.6 * std::cos(2.0 * i),
                       kSketchTruth.y + 0.6 * std::sin(2.0 * i), yaw);
  }
  poses[static_cast<std::size_t>(right)] = kSketchTruth * Pose2(0.15, -0.1, 0.05);
  return poses;
}

bool isAtTruth(const Pose2& pose) {
  const Pose2 error = kSketchTruth.inverse() * pose;
  return error.distance() < 0.03 && std::abs(error.yaw) < 0.02;
}

TEST(Sketch, TheRightHypothesisIsInTheHalfThatGoesOn) {
  const Submap map = room::map();
  const Points sample = sampleAt(kSketchTruth);
  for (int right = 0; right < 32; ++right) {
    WorkBudget budget(kSketchWork);
    const std::vector<Pose2> poses =
        sketches(map.surface(), sample, hypotheses(32, right), 4, budget);
    EXPECT_EQ(poses.size(), 16U);
    EXPECT_EQ(std::count_if(poses.begin(), poses.end(), isAtTruth), 1) << right;
  }
}

TEST(Sketch, FewHypothesesAllGoOn) {
  const Submap map = room::map();
  WorkBudget budget(kSketchWork);
  EXPECT_EQ(sketches(map.surface(), sampleAt(kSketchTruth), hypotheses(4, 1), 4, budget).size(),
            4U);
  EXPECT_TRUE(sketches(map.surface(), sampleAt(kSketchTruth), {}, 4, budget).empty());
}

TEST(Sketch, TheBudgetLimitsTheHypotheses) {
  const Submap map = room::map();
  const Points sample = sampleAt(kSketchTruth);
  WorkBudget whole(kSketchWork);
  sketches(map.surface(), sample, hypotheses(1, 0), 4, whole);
  WorkBudget budget(3 * whole.used());
  EXPECT_EQ(sketches(map.surface(), sample, hypotheses(32, 0), 4, budget).size(), 3U);
}

TEST(Sketch, PointsThatAreNotFiniteChangeNothing) {
  const Submap map = room::map();
  Points sample = sampleAt(kSketchTruth);
  sample.front().x() = std::numeric_limits<float>::quiet_NaN();
  WorkBudget budget(kSketchWork);
  for (const Pose2& pose : sketches(map.surface(), sample, hypotheses(8, 2), 4, budget))
    EXPECT_TRUE(std::isfinite(pose.x) && std::isfinite(pose.yaw));
}

TEST(SurfelLanes, FourValuesAreRoundedDownLikeOne) {
  for (const float value : {0.0F, -0.0F, 0.5F, -0.5F, 1.0F, -1.0F, 7.999F, -7.001F, 16777216.0F,
                            -16777217.0F, 1e9F, -1e9F}) {
    const Lanes values(value, -value, 1.5F, -1.5F);
    const auto rounded = floorToInt(values);
    for (int i = 0; i < static_cast<int>(kLanes); ++i)
      EXPECT_EQ(rounded[i], floorToInt(values[i])) << value;
  }
}

TEST(LastSurfels, ChangeNoSum) {
  const Submap map = room::map();
  Points points = hitsOf(room::scanFrom(Pose2(0.3, -0.2, 0.4)));
  while (points.size() % kLanes != 1) points.pop_back();
  LastSurfels surfels(points.size());
  // Long steps, steps within a cell, one out of the map, and back.
  for (const Pose2& pose :
       {Pose2(), Pose2(0.3, -0.2, 0.4), Pose2(0.301, -0.2, 0.4), Pose2(0.301, -0.203, 0.4001),
        Pose2(500.0, 0.0, 0.0), Pose2(0.3, -0.2, 0.4), Pose2(0.3, -0.2, 0.4)}) {
    const NormalEquations plain = linearizeDistance(map.surface(), points, pose, 0.05F);
    const NormalEquations same = linearizeDistance(map.surface(), points, pose, 0.05F, surfels);
    EXPECT_EQ(plain.cost, same.cost);
    EXPECT_EQ(plain.hessian, same.hessian);
    EXPECT_EQ(plain.gradient, same.gradient);
  }
}

}  // namespace
}  // namespace kestrel
