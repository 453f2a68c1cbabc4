// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/surfel_field.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "kestrel_slam/map/submap.h"
#include "room.h"

namespace kestrel {
namespace {

/// The surfel of the cell itself, or nullptr.
const Surfel* surfelOf(const Submap& map, const Cell& cell) {
  const Surfel* surfel = map.surface().nearest(map.grid().centerOf(cell));
  return surfel != nullptr && surfel->cell == cell ? surfel : nullptr;
}

/// Inserts scans of a room in which walls appear and disappear.
void insertRandomly(Submap& map, std::mt19937_64& random, int scans) {
  std::uniform_real_distribution<double> offset(-1.5, 1.5), angle(-kPi, kPi);
  for (int i = 0; i < scans; ++i) {
    std::vector<room::Segment> walls = room::walls();
    walls.resize(4 + random() % (walls.size() - 3));
    const Pose2 pose(offset(random), offset(random), angle(random));
    map.insert(room::scanFrom(pose, walls, 180), pose);
  }
}

TEST(SurfelField, HasASurfelExactlyInTheOccupiedCells) {
  std::mt19937_64 random(7);
  Submap map{OccupancyGridConfig()};
  for (int round = 0; round < 20; ++round) {
    insertRandomly(map, random, 3);
    std::size_t occupied = 0;
    for (int y = -90; y < 90; ++y) {
      for (int x = -110; x < 110; ++x) {
        const bool is_occupied = map.grid().isOccupied({x, y});
        occupied += is_occupied ? 1U : 0U;
        ASSERT_EQ(surfelOf(map, {x, y}) != nullptr, is_occupied) << x << " " << y;
      }
    }
    ASSERT_EQ(map.surface().size(), occupied);
  }
}

TEST(SurfelField, ReturnsTheSurfelsOfAnArea) {
  std::mt19937_64 random(9);
  Submap map{OccupancyGridConfig()};
  insertRandomly(map, random, 20);
  const Eigen::AlignedBox2f everything(Eigen::Vector2f(-1e4F, -1e4F), Eigen::Vector2f(1e4F, 1e4F));
  const std::vector<Surfel> all = map.surface().surfelsIn(everything);
  EXPECT_EQ(all.size(), map.surface().size());
  const Eigen::AlignedBox2f area(Eigen::Vector2f(-2.0F, 0.5F), Eigen::Vector2f(4.03F, 3.02F));
  std::vector<Eigen::Vector2f> expected, found;
  for (const Surfel& surfel : all) {
    if (area.contains(surfel.mean)) expected.push_back(surfel.mean);
  }
  for (const Surfel& surfel : map.surface().surfelsIn(area)) found.push_back(surfel.mean);
  EXPECT_GT(expected.size(), 50U);
  EXPECT_LT(expected.size(), all.size());
  EXPECT_EQ(found, expected);
}

TEST(SurfelField, NearestAgreesWithBruteForceAfterInsertionsAndRemovals) {
  std::mt19937_64 random(8);
  Submap map{OccupancyGridConfig()};
  insertRandomly(map, random, 60);
  std::vector<const Surfel*> all;
  for (int y = -90; y < 90; ++y) {
    for (int x = -110; x < 110; ++x) {
      if (const Surfel* surfel = surfelOf(map, {x, y})) all.push_back(surfel);
    }
  }
  // After a surfel was spread, its mean may still move by less than a cell. Both distances of a
  // comparison may differ by that.
  const float tolerance = 2.0F * 0.05F;
  const float reach = SurfelField::kReachCells * 0.05F;
  for (int y = -90; y < 90; y += 3) {
    for (int x = -110; x < 110; x += 3) {
      const Eigen::Vector2f center = map.grid().centerOf({x, y});
      float nearest = 1e9F;
      for (const Surfel* surfel : all) nearest = std::min(nearest, (surfel->mean - center).norm());
      const Surfel* found = map.surface().nearest(center);
      if (nearest < reach - tolerance) {
        ASSERT_NE(found, nullptr) << x << " " << y;
        ASSERT_LT((found->mean - center).norm(), nearest + tolerance);
      } else if (nearest > reach + tolerance) {
        ASSERT_EQ(found, nullptr) << x << " " << y;
      }
    }
  }
}

TEST(SurfelField, FourCellsHaveTheSurfelsOfEach) {
  std::mt19937_64 random(10);
  Submap map{OccupancyGridConfig()};
  insertRandomly(map, random, 10);
  const SurfelField& field = map.surface();
  std::uniform_int_distribution<int> coordinate(-110, 110), far(-5000, 5000);
  int without = 0, with = 0;
  for (int i = 0; i < 5000; ++i) {
    FourInts x, y;
    for (int k = 0; k < 4; ++k) x[k] = coordinate(random), y[k] = coordinate(random);
    if (i % 5 == 0) x[i % 4] = far(random);
    const auto four = field.nearestOrZeros(x, y);
    for (int k = 0; k < 4; ++k) {
      const Surfel* one = field.nearestTo(Cell{x[k], y[k]});
      const Surfel* of_four = four[static_cast<std::size_t>(k)];
      ++(one == nullptr ? without : with);
      if (one != nullptr) {
        ASSERT_EQ(of_four, one) << x[k] << " " << y[k];
      } else {
        ASSERT_TRUE(of_four->a11 == 0.0F && of_four->a12 == 0.0F && of_four->a22 == 0.0F);
        ASSERT_TRUE(of_four->on_wall.isZero()) << x[k] << " " << y[k];
      }
    }
  }
  EXPECT_GT(without, 1000);
  EXPECT_GT(with, 1000);
}

TEST(SurfelField, MeanAndShapeAreThoseOfTheWall) {
  // A wall in the direction 0.3 rad, seen from 3 m with a beam every 2 cm.
  Submap map{OccupancyGridConfig()};
  const Eigen::Vector2f along(std::cos(0.3F), std::sin(0.3F)), normal(-along.y(), along.x());
  PlanarScan scan;
  for (int i = -75; i <= 75; ++i) {
    scan.rays.push_back(
        {Eigen::Vector2f::Zero(), 3.0F * normal + 0.02F * static_cast<float>(i) * along, true});
  }
  map.insert(scan, Pose2());
  int checked = 0;
  for (int i = -60; i <= 60; i += 10) {
    const Surfel* surfel =
        map.surface().nearest(3.0F * normal + 0.02F * static_cast<float>(i) * along);
    ASSERT_NE(surfel, nullptr);
    EXPECT_NEAR(surfel->mean.dot(normal), 3.0F, 1e-3F);
    const float across = surfel->a11 * normal.x() * normal.x() +
                         2 * surfel->a12 * normal.x() * normal.y() +
                         surfel->a22 * normal.y() * normal.y();
    const float along_wall = surfel->a11 * along.x() * along.x() +
                             2 * surfel->a12 * along.x() * along.y() +
                             surfel->a22 * along.y() * along.y();
    EXPECT_NEAR(across, 1.0F, 0.02F);
    EXPECT_NEAR(along_wall, kAlongWeight, 0.02F);
    ++checked;
  }
  EXPECT_EQ(checked, 13);
}

TEST(SurfelField, SparseHitsOfOneScanFormALine) {
  // Hits 0.4 m apart are no neighbors in the map, but they are neighbors in the scan.
  Submap map{OccupancyGridConfig()};
  PlanarScan scan;
  for (int i = -5; i <= 5; ++i) {
    scan.rays.push_back(
        {Eigen::Vector2f::Zero(), Eigen::Vector2f(0.4F * static_cast<float>(i), 2.02F), true});
  }
  map.insert(scan, Pose2());
  const Surfel* surfel = map.surface().nearest({0.4F, 2.02F});
  ASSERT_NE(surfel, nullptr);
  EXPECT_NEAR(surfel->a22, 1.0F, 1e-3F);
  EXPECT_NEAR(surfel->a11, kAlongWeight, 1e-3F);
}

/// A scan of a straight wall at `y` with the noise of a laser, seen from the origin.
PlanarScan noisyWall(float y, std::mt19937_64& random) {
  std::normal_distribution<float> noise(0.0F, 0.01F);
  PlanarScan scan;
  for (float x = -1.0F; x < 1.0F; x += 0.01F) {
    scan.rays.push_back({Eigen::Vector2f::Zero(), {x, y + noise(random)}, true});
  }
  return scan;
}

TEST(SurfelField, AWallOnTheBorderOfTwoRowsOfCellsIsOneWall) {
  constexpr float kBorder = 1.25F;
  for (const float y : {kBorder - 0.005F, kBorder, kBorder + 0.005F}) {
    std::mt19937_64 random(10);
    Submap map{OccupancyGridConfig()};
    for (int i = 0; i < 10; ++i) map.insert(noisyWall(y, random), Pose2());
    int below = 0, above = 0;
    for (float x = -0.8F; x < 0.8F; x += 0.05F) {
      for (const float side : {-0.01F, 0.01F}) {
        const Surfel* surfel = map.surface().nearest({x, kBorder + side});
        ASSERT_NE(surfel, nullptr);
        EXPECT_NEAR(surfel->on_wall.y(), y, 0.006F) << x;
        (surfel->mean.y() < kBorder ? below : above) += 1;
      }
    }
    EXPECT_GT(below, 10);  // else the wall is not in both rows
    EXPECT_GT(above, 10);
  }
}

TEST(SurfelField, MarksWhatAppearsInFreeSpace) {
  Submap map{OccupancyGridConfig()};
  const auto insert = [&](const std::vector<room::Segment>& walls) {
    map.insert(room::scanFrom(Pose2(), walls, 1440, 20.0), Pose2());
  };
  std::vector<room::Segment> walls = room::corridor();
  walls.push_back({8.0, -1.0, 8.0, 1.0});
  insert(walls);
  walls.push_back({5.0, -0.5, 5.0, 0.5});
  insert(walls);
  insert(walls);
  const auto appeared = [&](float x, float y) { return map.surface().nearest({x, y})->appeared; };
  EXPECT_TRUE(appeared(5.0F, 0.0F));
  EXPECT_FALSE(appeared(8.0F, 0.0F));
  EXPECT_FALSE(appeared(2.0F, 1.0F));
  EXPECT_FALSE(appeared(2.0F, -1.0F));
}

}  // namespace
}  // namespace kestrel
