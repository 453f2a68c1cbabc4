// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/level_surfaces.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

Eigen::Quaterniond pitched(double pitch) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()));
}

/// The returns of a sweep that is pitched forward by `pitch` (rad): from a wall at x = `wall`, and
/// from a ceiling `ceiling` m above the base and behind it.
std::vector<Eigen::Vector3f> returnsOf(double pitch, double wall, double ceiling) {
  std::vector<Eigen::Vector3f> returns;
  for (int i = 0; i < 60; ++i) {
    const double side = 0.05 * (i - 30);
    returns.push_back(Eigen::Vector3d(wall, side, -wall * std::tan(pitch)).cast<float>());
    returns.push_back(Eigen::Vector3d(-ceiling / std::tan(pitch), side, ceiling).cast<float>());
  }
  return returns;
}

TEST(LevelSurfaces, RemembersACeilingAndIgnoresAWall) {
  LevelSurfaces surfaces;
  for (int i = 0; i < 20; ++i) {
    const double pitch = degToRad(5.0 + 0.5 * i), time = 0.05 * i;
    EXPECT_TRUE(surfaces.isDue(time));
    surfaces.observe(time, returnsOf(pitch, 3.0, 1.5), pitched(pitch), 1.0);
    EXPECT_FALSE(surfaces.isDue(time + 0.01));
  }
  ASSERT_TRUE(surfaces.ceilingHeight(0.95, 1.0));
  EXPECT_NEAR(*surfaces.ceilingHeight(0.95, 1.0), 1.5, 0.01);
  EXPECT_NEAR(*surfaces.ceilingHeight(100.0, 2.0), 0.5, 0.01)
      << "its height over the floor is constant";
  EXPECT_FALSE(surfaces.ceilingHeight(100.0, std::nullopt))
      << "it expires if the height is unknown";
  EXPECT_FALSE(surfaces.floorHeight(0.95)) << "the wall ahead is not the floor";
}

TEST(LevelSurfaces, FindsALineOnlyWithTiltAndReturns) {
  EXPECT_FALSE(outermostLine(returnsOf(0.02, 3.0, 1.0), pitched(0.02), +1));
  EXPECT_FALSE(outermostLine({}, pitched(0.2), +1));
  const auto highest = outermostLine(returnsOf(0.2, 3.0, 1.0), pitched(0.2), +1);
  ASSERT_TRUE(highest);
  EXPECT_NEAR(highest->height_m, 1.0, 1e-6);
  const auto lowest = outermostLine(returnsOf(0.2, 3.0, 1.0), pitched(0.2), -1);
  ASSERT_TRUE(lowest);
  EXPECT_NEAR(lowest->height_m, -3.0 * std::tan(0.2), 1e-6);
}

}  // namespace
}  // namespace kestrel
