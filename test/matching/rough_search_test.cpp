// SPDX-License-Identifier: BSD-3-Clause
// The rough search of a window: it finds the pose, and keeps its budget.

#include "../../src/matching/rough_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "kestrel_slam/experiments/mapped_log.h"
#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr std::int64_t kEnough = 1'000'000'000;
/// The budget of a scan.
constexpr std::int64_t kLimit = 14'000'000;
/// A descent converges from here.
constexpr double kBasinM = 0.35, kBasinRad = 0.15;

CorrelativeConfig withoutPreference() {
  CorrelativeConfig config;
  config.linear_preference = config.angular_preference = 0.0;
  return config;
}

bool isFound(const Hypotheses& hypotheses, const Pose2& truth) {
  return std::any_of(hypotheses.poses.begin(), hypotheses.poses.end(), [&](const Pose2& pose) {
    const Pose2 error = truth.inverse() * pose;
    return error.distance() < kBasinM && std::abs(error.yaw) < kBasinRad;
  });
}

Hypotheses search(const Submap& map, const Points& points, const RoughWindow& window,
                  WorkBudget& budget) {
  return searchRoughly(map.surface(), points, window, budget);
}

TEST(RoughSearch, FindsThePoseInEveryWindow) {
  const Submap map = room::map();
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  for (const SearchWindow& size : {SearchWindow{0.6, 0.52}, {1.0, 1.57}, {1.0, kPi}, {8.0, kPi}}) {
    for (int i = 0; i < 20; ++i) {
      const Pose2 truth(share(random), share(random), kPi * share(random));
      const Pose2 center(truth.x + size.linear_m * share(random),
                         truth.y + size.linear_m * share(random),
                         truth.yaw + size.angular_rad * share(random));
      WorkBudget budget(kEnough);
      const Hypotheses found = search(map, hitsOf(room::scanFrom(truth)),
                                      {center, size, CorrelativeConfig(), {}, 0}, budget);
      EXPECT_TRUE(found.complete);
      EXPECT_TRUE(isFound(found, truth)) << size.linear_m << " m, " << i;
    }
  }
}

TEST(RoughSearch, ASmallBudgetDividesTheWindowAndForgetsNoPart) {
  const Submap map = room::map();
  const Pose2 truth(0.3, -0.2, 0.4);
  const Points points = hitsOf(room::scanFrom(truth));
  constexpr int kSearches = 12;
  for (const Pose2& offset : {Pose2(7.5, 7.5, 0), Pose2(-7.5, 2, 0), Pose2(0, -7.5, 2), Pose2()}) {
    const Pose2 center(truth.x + offset.x, truth.y + offset.y, truth.yaw + offset.yaw);
    int needed = 0;
    for (bool found = false; !found && needed < kSearches; ++needed) {
      WorkBudget budget(2'500'000);
      const Hypotheses part =
          search(map, points, {center, {8.0, kPi}, withoutPreference(), {}, needed}, budget);
      EXPECT_LE(budget.used(), 2'500'000);
      EXPECT_FALSE(part.complete);
      found = isFound(part, truth);
    }
    EXPECT_LT(needed, kSearches) << offset.x << ", " << offset.y;
  }
}

TEST(RoughSearch, FindsNothingInAnEmptyMapOrWithoutPoints) {
  const Submap empty{OccupancyGridConfig()};
  const RoughWindow window{Pose2(1, 2, 3), {1.0, kPi}, CorrelativeConfig(), {}, 0};
  WorkBudget budget(kEnough);
  EXPECT_TRUE(search(empty, {Eigen::Vector2f(1, 1)}, window, budget).poses.empty());
  EXPECT_TRUE(search(room::map(), {}, window, budget).poses.empty());
}

TEST(RoughSearch, LeavesOutExcludedPoses) {
  const Pose2 truth(0.3, -0.2, 0.4);
  RoughWindow window{truth, {1.0, kPi}, CorrelativeConfig(), {}, 0};
  window.excluded = {truth, 0.5, 0.35};
  WorkBudget budget(kEnough);
  const Hypotheses found = search(room::map(), hitsOf(room::scanFrom(truth)), window, budget);
  EXPECT_FALSE(found.poses.empty());
  for (const Pose2& pose : found.poses) EXPECT_FALSE(isNear(window.excluded, pose));
}

/// Random points up to 80 m away.
Points noise(std::size_t count) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<float> coordinate(-56.0F, 56.0F);
  Points points;
  for (std::size_t i = 0; i < count; ++i)
    points.emplace_back(coordinate(random), coordinate(random));
  return points;
}

TEST(RoughSearch, TheWorkDoesNotGrowWithTheScan) {
  Submap map{OccupancyGridConfig()};
  PlanarScan scan;
  for (const Eigen::Vector2f& p : noise(20000)) scan.rays.push_back({p, p, true});
  map.insert(scan, Pose2());
  for (const std::size_t beams : {181U, 1081U, 5000U, 20000U}) {
    for (const SearchWindow& size : {SearchWindow{1.0, 1.57}, {1.0, kPi}, {8.0, kPi}}) {
      WorkBudget budget(kLimit);
      const Hypotheses found =
          search(map, noise(beams), {Pose2(1, 1, 1), size, CorrelativeConfig(), {}, 0}, budget);
      EXPECT_TRUE(found.complete) << beams << " beams, " << size.linear_m << " m";
      EXPECT_LE(budget.used(), kLimit);
    }
  }
}

/// In a real building: as often as the exhaustive search finds it.
TEST(RoughSearch, FindsThePoseInARecording) {
  const std::string folder = dataFolder();
  SKIP_WITHOUT_DATA(folder);
  const MappedLog log = mapLog(folder + "/freiburg/fr079.clf.bz2", 0.05);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  for (const SearchWindow& size : {SearchWindow{0.6, 0.52}, {1.0, 1.57}, {8.0, kPi}}) {
    constexpr std::size_t kCount = 100;
    std::size_t found = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
      const MappedScan& scan = log.scans[i * log.scans.size() / kCount];
      const Pose2 center(scan.pose.x + size.linear_m * share(random),
                         scan.pose.y + size.linear_m * share(random),
                         scan.pose.yaw + size.angular_rad * share(random));
      WorkBudget budget(kLimit);
      const RoughWindow window{center, size, withoutPreference(), {}, 0};
      found += isFound(search(log.map, scan.points, window, budget), scan.pose) ? 1U : 0U;
    }
    EXPECT_GE(found, size.linear_m > 1.0 ? 90U : 98U) << size.linear_m << " m";
  }
}

}  // namespace
}  // namespace kestrel
