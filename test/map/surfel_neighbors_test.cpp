// SPDX-License-Identifier: BSD-3-Clause
// Tests the nearest surfel of every cell after thousands of single cells were added and removed.

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "kestrel_slam/map/submap.h"

namespace kestrel {
namespace {

constexpr float kSize = 0.05F;  // size of a cell, m
constexpr int kHalf = 25;       // cells in [-kHalf, kHalf) are added and removed
constexpr int kReach = SurfelField::kReachCells;

/// Always the same point for a cell, so that its mean does not move.
Eigen::Vector2f pointIn(const Cell& cell) {
  const auto hash =
      static_cast<unsigned>(cell.x * 73856093) ^ static_cast<unsigned>(cell.y * 19349663);
  const float u = 0.05F + 0.9F * static_cast<float>(hash % 101U) / 100.0F;
  const float v = 0.05F + 0.9F * static_cast<float>(hash / 101U % 101U) / 100.0F;
  return {(static_cast<float>(cell.x) + u) * kSize, (static_cast<float>(cell.y) + v) * kSize};
}

/// A hit whose beam clears no cell.
PlanarRay hitIn(const Cell& cell) { return {pointIn(cell), pointIn(cell), true}; }

/// A beam that clears only this cell.
PlanarRay missIn(const Cell& cell) {
  const Eigen::Vector2f from((static_cast<float>(cell.x) + 0.25F) * kSize,
                             (static_cast<float>(cell.y) + 0.5F) * kSize);
  return {from, from + Eigen::Vector2f(1.05F * kSize, 0.0F), false};
}

/// A configuration in which one miss cancels one hit.
OccupancyGridConfig singleMissClears() {
  OccupancyGridConfig config;
  config.miss_probability = 0.05;
  config.min_probability = 0.04;
  return config;
}

class SurfelNeighbors : public ::testing::Test {
 protected:
  /// Adds and removes up to eight cells at once.
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

  /// Squared distance in cells² from the center of a cell to the nearest mean of a surfel within
  /// reach; infinite if there is none.
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
    // Distances are stored in steps of 1/512 cell², and floats are rounded.
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
          ASSERT_EQ(found->cell, cell) << "an occupied cell must have its own surfel";
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
  Submap map_{singleMissClears()};
  std::vector<Cell> occupied_;
};

TEST_F(SurfelNeighbors, AreTheNearestAfterThousandsOfInsertionsAndRemovals) {
  std::size_t most = 0;
  for (int round = 0; round < 100; ++round) {
    for (int i = 0; i < 30; ++i) changeSome();
    ASSERT_EQ(surfels(), occupied()) << "round " << round;
    ASSERT_NO_FATAL_FAILURE(expectAllNearest()) << "round " << round;
    most = std::max(most, occupied());
  }
  EXPECT_GT(most, 10U);  // the map must be neither empty nor full
  EXPECT_LT(most, 400U);
}

}  // namespace
}  // namespace kestrel
