// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/simulation/world.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/random.h"
#include "simulation/cast.h"

namespace kestrel {
namespace {

Eigen::Vector3d level(double degrees) {
  return {std::cos(degToRad(degrees)), std::sin(degToRad(degrees)), 0.0};
}

World worldOf(std::vector<Box> boxes, std::vector<Cylinder> cylinders = {}) {
  World::Parts parts;
  parts.boxes = std::move(boxes);
  parts.cylinders = std::move(cylinders);
  return World(std::move(parts));
}

// ---- an independent oracle, which tests every surface -------------------------------------------

bool inside(const Box& box, const Eigen::Vector3d& point, double tolerance) {
  const Eigen::Vector3d local =
      Eigen::AngleAxisd(-box.yaw, Eigen::Vector3d::UnitZ()) * (point - box.center);
  return ((local.cwiseAbs() - box.size / 2.0).array() <= tolerance).all();
}

/// Distance along the ray to the nearest of the six faces of a box.
double oracle(const Box& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  double nearest = kInfinity;
  const Eigen::Matrix3d axes =
      Eigen::AngleAxisd(box.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Vector3d normal = sign * axes.col(axis);
      const Eigen::Vector3d on_face = box.center + normal * (box.size[axis] / 2.0);
      const double along = normal.dot(on_face - origin) / normal.dot(direction);
      if (!(along >= 0.0) || !inside(box, origin + along * direction, 1e-9)) continue;
      nearest = std::min(nearest, along);
    }
  }
  return nearest;
}

/// The same for the top, bottom and side of a cylinder.
double oracle(const Cylinder& cylinder, const Eigen::Vector3d& origin,
              const Eigen::Vector3d& direction) {
  double nearest = kInfinity;
  const auto consider = [&](double along) {
    const Eigen::Vector3d point = origin + along * direction;
    const bool on_it = (point.head<2>() - cylinder.center).norm() <= cylinder.radius + 1e-9 &&
                       point.z() >= cylinder.bottom - 1e-9 && point.z() <= cylinder.top + 1e-9;
    if (along >= 0.0 && on_it) nearest = std::min(nearest, along);
  };
  consider((cylinder.top - origin.z()) / direction.z());
  consider((cylinder.bottom - origin.z()) / direction.z());
  const double level_share = direction.head<2>().norm();
  const Eigen::Vector2d direction_xy = direction.head<2>() / level_share;
  const Eigen::Vector2d to_axis = cylinder.center - origin.head<2>();
  const double foot = direction_xy.dot(to_axis);
  const double miss = (to_axis - foot * direction_xy).norm();
  if (miss < cylinder.radius) {
    const double half_chord = std::sqrt(cylinder.radius * cylinder.radius - miss * miss);
    consider((foot - half_chord) / level_share);
    consider((foot + half_chord) / level_share);
  }
  return nearest;
}

double oracle(const World& world, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  double nearest = kInfinity;
  for (const Box& box : world.parts().boxes)
    nearest = std::min(nearest, oracle(box, origin, direction));
  for (const Cylinder& cylinder : world.parts().cylinders) {
    nearest = std::min(nearest, oracle(cylinder, origin, direction));
  }
  const double vertical = direction.z() < 0.0 ? 0.0 : world.parts().ceiling_m;
  return std::min(nearest, (vertical - origin.z()) / direction.z());
}

bool isFree(const World& world, const Eigen::Vector3d& point) {
  for (const Box& box : world.parts().boxes) {
    if (inside(box, point, 1e-3)) return false;
  }
  for (const Cylinder& cylinder : world.parts().cylinders) {
    if ((point.head<2>() - cylinder.center).norm() < cylinder.radius + 1e-3) return false;
  }
  return true;
}

Eigen::Vector3d randomPoint(Random& random, double half_width) {
  return {random.uniform(-half_width, half_width), random.uniform(-half_width, half_width),
          random.uniform(0.05, 2.95)};
}

Eigen::Vector3d randomDirection(Random& random) {
  return Eigen::Vector3d(random.gaussian(), random.gaussian(), 0.3 * random.gaussian())
      .normalized();
}

World randomWorld(Random& random, double half_width, int count) {
  World::Parts parts;
  for (int i = 0; i < count; ++i) {
    Box box;
    box.center = randomPoint(random, half_width);
    box.size = {random.uniform(0.02, 3.0), random.uniform(0.02, 1.0), random.uniform(0.02, 3.0)};
    box.yaw = random.uniform() < 0.3 ? 0.0 : random.uniform(-kPi, kPi);
    parts.boxes.push_back(box);
    Cylinder cylinder;
    cylinder.center = randomPoint(random, half_width).head<2>();
    cylinder.radius = random.uniform(0.02, 0.8);
    cylinder.bottom = random.uniform(0.0, 1.0);
    cylinder.top = cylinder.bottom + random.uniform(0.1, 2.0);
    parts.cylinders.push_back(cylinder);
  }
  return World(std::move(parts));
}

// ---- planes ----

TEST(World, BeamHitsAWall) {
  const World world = worldOf({{{5.5, 0.0, 1.5}, {1.0, 40.0, 3.0}}});
  for (int degrees = -70; degrees <= 70; ++degrees) {
    const RayHit hit = world.cast({0.0, 0.0, 1.0}, level(degrees), 0.0, kFar);
    EXPECT_NEAR(hit.distance, 5.0 / std::cos(degToRad(degrees)), 1e-12);
    EXPECT_NEAR(hit.cosine, std::cos(degToRad(degrees)), 1e-12);
  }
}

TEST(World, TiltedBeamHitsFloorAndCeiling) {
  const World world = worldOf({});
  for (int degrees = 1; degrees <= 90; ++degrees) {
    const double tilt = degToRad(degrees);
    const Eigen::Vector3d down(std::cos(tilt), 0.0, -std::sin(tilt));
    const Eigen::Vector3d up(0.0, -std::cos(tilt), std::sin(tilt));
    EXPECT_NEAR(distance(world, {3.0, 4.0, 1.2}, down), 1.2 / std::sin(tilt), 1e-10);
    EXPECT_NEAR(distance(world, {3.0, 4.0, 1.2}, up), 1.8 / std::sin(tilt), 1e-10);
    EXPECT_NEAR(world.cast({0, 0, 1}, down, 0.0, kFar).cosine, std::sin(tilt), 1e-12);
  }
  EXPECT_EQ(distance(world, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}), kInfinity);
}

TEST(World, OpenSkyGivesNoHit) {
  World::Parts parts;
  parts.ceiling_m = kInfinity;
  EXPECT_EQ(distance(World(parts), {0, 0, 1}, {0, 0, 1}), kInfinity);
  EXPECT_EQ(World(parts).cast({0, 0, 1}, {0, 0, 1}, 0.0, kInfinity).distance, kInfinity);
  EXPECT_EQ(World(parts).cast({0, 0, 1}, {0, 0, -1}, 0.0, kInfinity).distance, 1.0);
}

// ---- solids ----

TEST(World, RotatedBoxIsHitOnFacesAndCorners) {
  const World world = worldOf({{{4.0, 0.0, 1.0}, {2.0, 2.0, 2.0}, kPi / 4.0}});
  EXPECT_NEAR(distance(world, {0, 0, 1}, {1, 0, 0}), 4.0 - std::sqrt(2.0), 1e-12);
  // Parallel to the axis and one meter beside the corner, the face at 45 degrees is one meter
  // deeper.
  const RayHit hit = world.cast({0, 1, 1}, {1, 0, 0}, 0.0, kFar);
  EXPECT_NEAR(hit.distance, 4.0 - std::sqrt(2.0) + 1.0, 1e-12);
  EXPECT_NEAR(hit.cosine, std::sqrt(0.5), 1e-12);
  EXPECT_EQ(distance(world, {0, 1.42, 1}, {1, 0, 0}), kInfinity);
}

TEST(World, BeamsPassAboveAndBelowATableTop) {
  const World world = worldOf({{{3.0, 0.0, 0.73}, {1.0, 1.0, 0.02}}});
  EXPECT_EQ(distance(world, {0, 0, 0.70}, {1, 0, 0}), kInfinity);
  EXPECT_EQ(distance(world, {0, 0, 0.75}, {1, 0, 0}), kInfinity);
  EXPECT_NEAR(distance(world, {0, 0, 0.73}, {1, 0, 0}), 2.5, 1e-12);
  EXPECT_NEAR(distance(world, {3, 0, 2.0}, {0, 0, -1}), 2.0 - 0.74, 1e-12);
  EXPECT_NEAR(distance(world, {3, 0, 0.1}, {0, 0, 1}), 0.72 - 0.1, 1e-12);
  EXPECT_NEAR(distance(world, {4, 0, 1.0}, {0, 0, -1}), 1.0, 1e-12);
}

TEST(World, ACylinderIsRound) {
  const World world = worldOf({}, {{{0.0, 0.0}, 0.5, 0.0, 2.0}});
  for (int degrees = 0; degrees < 360; ++degrees) {
    const Eigen::Vector3d towards = level(degrees);
    const Eigen::Vector3d from = Eigen::Vector3d(0, 0, 1) - 3.0 * towards;
    EXPECT_NEAR(distance(world, from, towards), 2.5, 1e-12);
    // A beam that passes the axis at 0.3 m gives a 3-4-5 triangle.
    const Eigen::Vector3d beside = from + 0.3 * level(degrees + 90);
    const RayHit hit = world.cast(beside, towards, 0.0, kFar);
    EXPECT_NEAR(hit.distance, 3.0 - 0.4, 1e-12);
    EXPECT_NEAR(hit.cosine, 0.8, 1e-12);
  }
  EXPECT_NEAR(distance(world, {0.2, 0.2, 2.5}, {0, 0, -1}), 0.5, 1e-12);
  EXPECT_EQ(distance(world, {-3, 0, 2.01}, {1, 0, 0}), kInfinity);
}

TEST(World, NearestSolidIsHitAndNothingBeyondTheLimit) {
  const World world =
      worldOf({{{6, 0, 1}, {1, 1, 2}}, {{9, 0, 1}, {1, 1, 2}}}, {{{3, 0}, 0.5, 0, 2}});
  EXPECT_DOUBLE_EQ(distance(world, {0, 0, 1}, {1, 0, 0}), 2.5);
  EXPECT_DOUBLE_EQ(distance(world, {4, 0, 1}, {1, 0, 0}), 1.5);
  EXPECT_DOUBLE_EQ(distance(world, {7, 0, 1}, {1, 0, 0}), 1.5);
  EXPECT_EQ(world.cast({0, 0, 1}, {1, 0, 0}, 0.0, 2.49).distance, kInfinity);
  EXPECT_DOUBLE_EQ(world.cast({0, 0, 1}, {1, 0, 0}, 0.0, 2.51).distance, 2.5);
}

TEST(World, InsideASolidTheDistanceIsZero) {
  const World world = worldOf({{{0, 0, 1}, {2, 2, 2}}}, {{{5, 0}, 0.5, 0, 2}});
  for (int degrees = 0; degrees < 360; degrees += 15) {
    EXPECT_EQ(distance(world, {0.5, 0.5, 1}, level(degrees)), 0.0);
    EXPECT_EQ(distance(world, {5.1, 0.1, 1}, level(degrees)), 0.0);
  }
}

TEST(World, AgreesWithTheOracleOnRandomRays) {
  Random random(11);
  for (const double half_width : {2.0, 8.0, 40.0}) {
    const World world = randomWorld(random, half_width, 40);
    int met = 0, compared = 0;
    while (compared < 20000) {
      // Some origins lie outside of the grid.
      const Eigen::Vector3d origin = randomPoint(random, 1.5 * half_width);
      const Eigen::Vector3d direction = randomDirection(random);
      if (!isFree(world, origin)) continue;
      const double expected = oracle(world, origin, direction);
      ASSERT_NEAR(distance(world, origin, direction), expected, 1e-7)
          << "from " << origin.transpose() << " along " << direction.transpose();
      met +=
          expected < std::abs((direction.z() < 0 ? origin.z() : 3.0 - origin.z()) / direction.z());
      ++compared;
    }
    EXPECT_GT(met, 500);
  }
}

TEST(World, AgreesWithTheOracleAlongAxesAndCellBorders) {
  Random random(12);
  const World world = randomWorld(random, 6.0, 30);
  for (int i = 0; i < 4000; ++i) {
    Eigen::Vector3d origin = randomPoint(random, 8.0);
    origin.head<2>() = origin.head<2>().array().round();
    if (!isFree(world, origin)) continue;
    Eigen::Vector3d direction = level(45.0 * (i % 8));
    if (i % 2 == 0) direction = direction.array().round();  // exactly along an axis
    double expected = kInfinity;
    for (const Box& box : world.parts().boxes)
      expected = std::min(expected, oracle(box, origin, direction));
    for (const Cylinder& pole : world.parts().cylinders) {
      expected = std::min(expected, oracle(pole, origin, direction));
    }
    const double cast = distance(world, origin, direction);
    if (std::isinf(expected)) {
      ASSERT_EQ(cast, kInfinity);
    } else {
      ASSERT_NEAR(cast, expected, 1e-7);
    }
  }
}

// ---- materials ----

TEST(World, GlassReflectsOnlyPerpendicularBeams) {
  Box pane = {{2.0, 0.0, 1.5}, {0.01, 10.0, 3.0}, 0.0, Material::kGlass};
  const World world = worldOf({pane, {{4.5, 0.0, 1.5}, {1.0, 40.0, 3.0}}});
  const RayHit straight = world.cast({0, 0, 1}, level(3.0), 0.0, kFar);
  EXPECT_NEAR(straight.distance, 1.995 / std::cos(degToRad(3.0)), 1e-12);
  EXPECT_EQ(straight.material, Material::kGlass);
  const RayHit oblique = world.cast({0, 0, 1}, level(20.0), 0.0, kFar);
  EXPECT_NEAR(oblique.distance, 4.0 / std::cos(degToRad(20.0)), 1e-12);
  EXPECT_EQ(oblique.material, Material::kMatt);
}

TEST(World, BlackSolidsAbsorbTheBeam) {
  const World world = worldOf({{{2.5, 0.0, 1.0}, {1.0, 1.0, 2.0}, 0.0, Material::kBlack}});
  const RayHit hit = world.cast({0, 0, 1}, {1, 0, 0}, 0.0, kFar);
  EXPECT_DOUBLE_EQ(hit.distance, 2.0);
  EXPECT_EQ(hit.material, Material::kBlack);
}

// ---- other ----

TEST(World, BoxExistsOnlyDuringItsTime) {
  Box before = {{3, 0, 1}, {2, 2, 2}}, after = {{6, 0, 1}, {2, 2, 2}};
  before.until_s = after.from_s = 10.0;
  const World world = worldOf({before, after});
  const auto seen = [&](double time) {
    return world.cast({0, 0, 1}, {1, 0, 0}, time, 100.0).distance;
  };
  EXPECT_DOUBLE_EQ(seen(0.0), 2.0);
  EXPECT_DOUBLE_EQ(seen(9.999), 2.0);
  EXPECT_DOUBLE_EQ(seen(10.0), 5.0);
  before.from_s = before.until_s;
  EXPECT_THROW(worldOf({before}), std::invalid_argument);
}

TEST(World, RejectsInvalidShapes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(worldOf({{{nan, 0, 0}, {1, 1, 1}}}), std::invalid_argument);
  EXPECT_THROW(worldOf({{{0, 0, 0}, {1, -1, 1}}}), std::invalid_argument);
  EXPECT_THROW(worldOf({{{0, 0, 0}, {1, 1, 1}, kInfinity}}), std::invalid_argument);
  EXPECT_THROW(worldOf({}, {{{0, 0}, 0.0}}), std::invalid_argument);
  EXPECT_THROW(worldOf({}, {{{0, 0}, 1.0, 2.0, 1.0}}), std::invalid_argument);
  World::Parts buried;
  buried.ceiling_m = -1.0;
  EXPECT_THROW(World{buried}, std::invalid_argument);
}

TEST(World, CanBeMoved) {
  World world = worldOf({{{3, 0, 1}, {2, 2, 2}}});
  World moved = std::move(world);
  EXPECT_DOUBLE_EQ(distance(moved, {0, 0, 1}, {1, 0, 0}), 2.0);
  EXPECT_EQ(moved.parts().boxes.size(), 1u);
}

}  // namespace
}  // namespace kestrel
