// SPDX-License-Identifier: BSD-3-Clause
// Which surfel a cell looks to, after thousands of cells came and went one by one.

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "kestrel_slam/map/submap.h"

namespace kestrel {
namespace {

constexpr float kSize = 0.05F;  // m, of a cell
constexpr int kHalf = 25;       // cells that come and go lie in [-kHalf, kHalf)
constexpr int kReach = SurfelField::kReachCells;

/// The same point of a cell every time, so that no mean moves.
Eigen::Vector2f pointIn(const Cell& cell) {
  const auto hash =
      static_cast<unsigned>(cell.x * 73856093) ^ static_cast<unsigned>(cell.y * 19349663);
  const float u = 0.05F + 0.9F * static_cast<float>(hash % 101U) / 100.0F;
  const float v = 0.05F + 0.9F * static_cast<float>(hash / 101U % 101U) / 100.0F;
  return {(static_cast<float>(cell.x) + u) * kSize, (static_cast<float>(cell.y) + v) * kSize};
}

/// A hit without a beam: nothing is cleared.
PlanarRay hitIn(const Cell& cell) { return {pointIn(cell), pointIn(cell), true}; }

/// A beam that passes this cell and no other.
PlanarRay missIn(const Cell& cell) {
  const Eigen::Vector2f from((static_cast<float>(cell.x) + 0.25F) * kSize,
                             (static_cast<float>(cell.y) + 0.5F) * kSize);
  return {from, from + Eigen::Vector2f(1.05F * kSize, 0.0F), false};
}

/// One miss undoes one hit.
OccupancyGridConfig forgetful() {
  OccupancyGridConfig config;
  config.miss_probability = 0.05;
  config.min_probability = 0.04;
  return config;
}

class Neighbors : public ::testing::Test {
 protected:
  /// Up to eight cells come and go at once.
  void changeSome() {
    PlanarScan scan;
    for (int i = 0; i < 4; ++i) {
      scan.rays.push_back(hitIn(anyCell()));
      scan.rays.push_back(missIn(anyCell()));
      if (!occupied_.empty()) scan.rays.push_back(missIn(occupied_[random_() % occupied_.size()]));
    }
    map_.insert(scan, Pose2());
    occupied_.clear();
    for (int y = -kHalf; y < kHalf; ++y) {
      for (int x = -kHalf; x < kHalf; ++x) {
        if (map_.grid().isOccupied({x, y})) occupied_.push_back({x, y});
      }
    }
  }

  /// Squared distance in cells² from the center of a cell to the nearest mean of a surfel whose
  /// cell is within reach; infinite where there is none.
  float nearest2(const Cell& cell) const {
    float best = std::numeric_limits<float>::infinity();
    for (const Cell& other : occupied_) {
      const int dx = other.x - cell.x, dy = other.y - cell.y;
      if (dx * dx + dy * dy > kReach * kReach) continue;
      best = std::min(best, distance2(cell, pointIn(other)));
    }
    return best;
  }

  float distance2(const Cell& cell, const Eigen::Vector2f& point) const {
    return ((point - map_.grid().centerOf(cell)) / kSize).squaredNorm();
  }

  void expectAllNearest() const {
    // Distances are kept in steps of 1/512 cell², and floats round.
    constexpr float kTolerance = 2.5F / 512.0F;
    for (int y = -kHalf - kReach - 3; y < kHalf + kReach + 3; ++y) {
      for (int x = -kHalf - kReach - 3; x < kHalf + kReach + 3; ++x) {
        const Cell cell{x, y};
        const Surfel* found = map_.surface().nearest(map_.grid().centerOf(cell));
        const float expected = nearest2(cell);
        ASSERT_EQ(found == nullptr, std::isinf(expected)) << x << " " << y;
        if (found == nullptr) continue;
        ASSERT_TRUE(map_.grid().isOccupied(found->cell)) << x << " " << y << ": a removed surfel";
        if (map_.grid().isOccupied(cell)) {
          ASSERT_EQ(found->cell, cell) << "an occupied cell has its own";
        } else {
          ASSERT_LE(distance2(cell, found->mean), expected + kTolerance) << x << " " << y;
        }
      }
    }
  }

  std::size_t occupied() const { return occupied_.size(); }
  std::size_t surfels() const { return map_.surface().size(); }

 private:
  Cell anyCell() {
    const auto coordinate = [this] { return static_cast<int>(random_() % (2 * kHalf)) - kHalf; };
    const int x = coordinate();
    return {x, coordinate()};
  }

  std::mt19937 random_{5};
  Submap map_{forgetful()};
  std::vector<Cell> occupied_;
};

TEST_F(Neighbors, AreTheNearestAfterThousandsOfInsertionsAndRemovals) {
  std::size_t most = 0;
  for (int round = 0; round < 100; ++round) {
    for (int i = 0; i < 30; ++i) changeSome();
    ASSERT_EQ(surfels(), occupied()) << "round " << round;
    ASSERT_NO_FATAL_FAILURE(expectAllNearest()) << "round " << round;
    most = std::max(most, occupied());
  }
  EXPECT_GT(most, 10U);  // neither empty nor full, or nothing was tested
  EXPECT_LT(most, 400U);
}

}  // namespace
}  // namespace kestrel
