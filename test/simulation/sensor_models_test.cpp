// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/simulation/sensor_models.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "simulation/cast.h"
#include "simulation/steady_motion.h"

namespace kestrel {
namespace {

LaserScan scan(const LaserModel& laser, const World& world, const Motion& motion = SteadyMotion(),
               double time = 0.0, std::uint64_t seed = 1) {
  Random random(seed);
  return sweep(laser, world, motion, kNoOffset, time, random);
}

/// A laser with `beams` beams that all point straight ahead.
LaserModel singleDirection(const LaserModel& model, int beams) {
  LaserModel laser = model;
  laser.beams = beams;
  laser.angle_min = laser.angle_increment = 0.0;
  return laser;
}

struct Statistics {
  double mean = 0.0, sigma = 0.0;
  int valid = 0, nan = 0, beyond = 0, close = 0;
};

Statistics statistics(const LaserScan& scan) {
  Statistics result;
  double sum = 0.0, squares = 0.0;
  for (const float range : scan.ranges) {
    result.nan += std::isnan(range);
    result.beyond += range == std::numeric_limits<float>::infinity();
    result.close += range == -std::numeric_limits<float>::infinity();
    if (!std::isfinite(range)) continue;
    sum += range;
    squares += static_cast<double>(range) * range;
    ++result.valid;
  }
  result.mean = sum / result.valid;
  result.sigma = std::sqrt(squares / result.valid - result.mean * result.mean);
  return result;
}

TEST(SensorModels, IdealBeamsHitAPlaneAtTheExactRange) {
  const LaserModel laser = laserModel("ideal");
  const LaserScan seen = scan(laser, wallAt(5.0));
  int compared = 0;
  for (std::size_t i = 0; i < seen.ranges.size(); ++i) {
    const double angle = seen.angle_min + static_cast<double>(i) * seen.angle_increment;
    const double expected = 5.0 / std::cos(angle);
    if (std::cos(angle) <= 0.0 || expected >= laser.range_max) {
      EXPECT_EQ(seen.ranges[i], std::numeric_limits<float>::infinity());
      continue;
    }
    EXPECT_NEAR(seen.ranges[i], expected, 1e-5);
    ++compared;
  }
  EXPECT_EQ(compared, 643);  // beams within acos(5 / 30) = 80.4 deg
}

TEST(SensorModels, ScanHasTheGeometryOfTheModel) {
  const LaserModel laser = laserModel("utm30lx");
  const LaserScan seen = scan(laser, wallAt(5.0), SteadyMotion(), 12.5);
  EXPECT_EQ(seen.stamp, 12.5);
  EXPECT_EQ(seen.ranges.size(), 1081u);
  EXPECT_EQ(seen.angle_min, laser.angle_min);
  EXPECT_EQ(seen.angle_increment, laser.angle_increment);
  EXPECT_EQ(seen.time_increment, laser.time_increment);
  EXPECT_EQ(seen.range_min, 0.1);
  EXPECT_EQ(seen.range_max, 30.0);
  // 270 of 360 degrees take three quarters of a turn of 25 ms.
  EXPECT_NEAR(seen.time_increment * 1080, 0.01875, 1e-12);
  EXPECT_NEAR(seen.angle_min + 1080 * seen.angle_increment, degToRad(135.0), 1e-12);
}

TEST(SensorModels, TiltedLaserHitsTheFloor) {
  SteadyMotion motion;
  const double pitch = degToRad(20.0);  // nose down
  motion.start.linear() = Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const LaserScan seen = scan(laserModel("ideal"), worldOf({}), motion);
  for (std::size_t i = 0; i < seen.ranges.size(); ++i) {
    const double angle = seen.angle_min + static_cast<double>(i) * seen.angle_increment;
    const double climb = -std::cos(angle) * std::sin(pitch);  // m per meter along the beam
    const double expected = climb < 0.0 ? -1.0 / climb : 2.0 / climb;
    if (!(expected < 29.9)) continue;
    EXPECT_NEAR(seen.ranges[i], expected, 1e-4) << "at beam " << i;
  }
}

TEST(SensorModels, MountingOfTheLaserIsApplied) {
  Random random(1);
  const Eigen::Isometry3d base_T_laser(Eigen::Translation3d(0.3, 0.0, 0.1) *
                                       Eigen::AngleAxisd(kPi / 2.0, Eigen::Vector3d::UnitZ()));
  const LaserScan seen =
      sweep(laserModel("ideal"), wallAt(5.0), SteadyMotion(), base_T_laser, 0.0, random);
  EXPECT_NEAR(seen.ranges[180], 4.7, 1e-6);  // -90 deg of a laser that looks to the left
  EXPECT_EQ(seen.ranges[540], std::numeric_limits<float>::infinity());
}

TEST(SensorModels, EachBeamIsCastFromThePoseAtItsOwnTime) {
  SteadyMotion motion;
  motion.velocity = {2.0, 0.0, 0.0};
  motion.yaw_rate = 2.0;
  const double time = 0.1;
  const LaserScan seen = scan(laserModel("ideal"), wallAt(5.0), motion, time);
  int compared = 0;
  for (std::size_t i = 0; i < seen.ranges.size(); ++i) {
    const double t = time + static_cast<double>(i) * seen.time_increment;
    const double angle =
        motion.yaw_rate * t + seen.angle_min + static_cast<double>(i) * seen.angle_increment;
    const double expected = (5.0 - 2.0 * t) / std::cos(angle);
    if (std::cos(angle) <= 0.0 || expected > 29.9) continue;
    EXPECT_NEAR(seen.ranges[i], expected, 1e-6 * expected + 1e-6);
    ++compared;
  }
  EXPECT_GT(compared, 500);
}

TEST(SensorModels, RangeNoiseMatchesTheDataSheet) {
  const LaserModel laser = singleDirection(laserModel("utm30lx"), 20000);
  const Statistics near = statistics(scan(laser, wallAt(1.0)));
  EXPECT_NEAR(near.mean, 1.0, 3e-4);
  EXPECT_NEAR(near.sigma, 0.01, 3e-4);
  const Statistics far = statistics(scan(laser, wallAt(20.0)));
  EXPECT_NEAR(far.mean, 20.0, 1e-3);
  EXPECT_NEAR(far.sigma, 0.0213, 5e-4);  // sqrt(0.01² + (0.00094 · 20)²)
  const Statistics urg =
      statistics(scan(singleDirection(laserModel("urg04lx"), 20000), wallAt(4.0)));
  EXPECT_NEAR(urg.sigma, 0.0401, 1e-3);  // 1 %
}

TEST(SensorModels, SomeBeamsDropOut) {
  const Statistics seen =
      statistics(scan(singleDirection(laserModel("urg04lx"), 20000), wallAt(4.0)));
  EXPECT_NEAR(seen.nan, 400, 80);  // 2 %
  EXPECT_EQ(statistics(scan(laserModel("ideal"), wallAt(4.0))).nan, 0);
}

TEST(SensorModels, RangesAreMultiplesOfTheResolution) {
  for (const char* name : {"utm30lx", "urg04lx", "sick180"}) {
    const LaserModel& laser = laserModel(name);
    for (const float range : scan(laser, wallAt(3.0)).ranges) {
      if (!std::isfinite(range)) continue;
      const double steps = range / laser.errors.resolution_m;
      EXPECT_NEAR(steps, std::round(steps), 1e-3) << name;
    }
  }
}

TEST(SensorModels, RangesOutsideTheLimitsFollowRep117) {
  const LaserModel laser = singleDirection(laserModel("ideal"), 10);
  EXPECT_EQ(statistics(scan(laser, wallAt(30.1))).beyond, 10);
  EXPECT_EQ(statistics(scan(laser, wallAt(29.9))).valid, 10);
  EXPECT_EQ(statistics(scan(laser, wallAt(0.09))).close, 10);
  EXPECT_EQ(statistics(scan(laser, wallAt(0.11))).valid, 10);
  // With noise, a wall at the limit is seen by about half of the beams.
  const Statistics limit =
      statistics(scan(singleDirection(laserModel("utm30lx"), 1000), wallAt(30.0)));
  EXPECT_NEAR(limit.valid, 500, 80);
}

TEST(SensorModels, NoReturnFromBlackSurfacesGlassAndGrazingIncidence) {
  LaserModel laser = singleDirection(laserModel("utm30lx"), 100);
  laser.errors.dropout_probability = 0.0;
  EXPECT_EQ(statistics(scan(laser, wallAt(5.0, Material::kBlack))).beyond, 100);
  laser.angle_min = degToRad(30.0);
  EXPECT_EQ(statistics(scan(laser, wallAt(5.0, Material::kGlass))).beyond, 100);
  laser.angle_min = degToRad(89.0);
  EXPECT_EQ(statistics(scan(laser, wallAt(0.3))).beyond, 100);  // 17 m away, at one degree
  laser.angle_min = degToRad(87.0);
  EXPECT_EQ(statistics(scan(laser, wallAt(0.3))).valid, 100);
}

TEST(SensorModels, BeamsAtAnEdgeMixBothSurfaces) {
  // A box 3 m away in front of a wall at 6 m; its left edge is at the bearing of 0.1 deg.
  LaserModel laser = laserModel("ideal");
  laser.errors.divergence_rad = degToRad(0.25);
  const double edge = 3.0 * std::tan(degToRad(0.1));
  const World world =
      worldOf({{{3.5, edge - 1.0, 1.5}, {1.0, 2.0, 3.0}}, {{6.5, 0.0, 1.5}, {1.0, 100.0, 3.0}}});
  double smallest = kInfinity, largest = 0.0;
  constexpr int kScans = 200;
  for (std::uint64_t seed = 0; seed < kScans; ++seed) {
    const LaserScan seen = scan(laser, world, SteadyMotion(), 0.0, seed);
    EXPECT_NEAR(seen.ranges[539], 3.0, 1e-3);  // this whole beam hits the box
    EXPECT_NEAR(seen.ranges[541], 6.0, 1e-3);  // and this one the wall
    smallest = std::min<double>(smallest, seen.ranges[540]);
    largest = std::max<double>(largest, seen.ranges[540]);
  }
  EXPECT_GE(smallest, 3.0 - 1e-4);
  EXPECT_LT(smallest, 3.1);
  EXPECT_GT(largest, 5.9);
  EXPECT_LE(largest, 6.0 + 1e-3);
}

TEST(SensorModels, EdgeWithoutABackgroundIsNotMixed) {
  LaserModel laser = laserModel("ideal");
  laser.errors.divergence_rad = degToRad(0.25);
  const World world = worldOf({{{3.5, 0.0, 1.5}, {1.0, 2.0, 3.0}}});
  for (const float range : scan(laser, world).ranges) {
    EXPECT_TRUE(!std::isfinite(range) || range < 3.2) << range;
  }
}

TEST(SensorModels, TheSameSeedGivesTheSameScan) {
  const LaserModel& laser = laserModel("utm30lx");
  const auto bits = [&](std::uint64_t seed) {
    std::vector<float> ranges = scan(laser, wallAt(5.0), SteadyMotion(), 0.0, seed).ranges;
    for (float& range : ranges) range = std::isnan(range) ? -1.0F : range;
    return ranges;
  };
  EXPECT_EQ(bits(3), bits(3));
  EXPECT_NE(bits(3), bits(4));
}

TEST(SensorModels, OneBeamDoesNotChangeTheNext) {
  const LaserModel& laser = laserModel("utm30lx");
  const Box wall = {{5.5, 0.0, 1.5}, {1.0, 500.0, 3.0}};
  const Box post = {{2.0, 0.0, 1.5}, {0.1, 0.1, 3.0}};
  const LaserScan without = scan(laser, worldOf({wall})), with = scan(laser, worldOf({wall, post}));
  int different = 0;
  for (std::size_t i = 0; i < with.ranges.size(); ++i) {
    if (std::isnan(with.ranges[i])) {
      EXPECT_TRUE(std::isnan(without.ranges[i]));
    } else if (with.ranges[i] != without.ranges[i]) {
      ++different;
    }
  }
  EXPECT_GT(different, 8);  // 0.1 m at 2 m are 2.9 deg: 12 beams
  EXPECT_LT(different, 16);
}

TEST(SensorModels, AreFoundByName) {
  for (const char* name : {"utm30lx", "urg04lx", "sick180", "alasca", "ideal"}) {
    EXPECT_EQ(laserModel(name).name, name);
    EXPECT_FALSE(laserModel(name).description.empty());
  }
  EXPECT_EQ(lidarModels().front().name, "vlp16");
  try {
    laserModel("sonar");
    FAIL() << "found a sonar";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "unknown sensor 'sonar'; known: utm30lx, urg04lx, sick180, alasca, ideal");
  }
}

}  // namespace
}  // namespace kestrel
