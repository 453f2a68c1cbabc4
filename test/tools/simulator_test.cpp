#include "kestrel_slam/tools/simulator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

namespace kestrel_slam {
namespace {

const std::vector<Wall> kWallAtFive = {{{5.0, -10.0}, {5.0, 10.0}}};

const std::vector<Wall> kBox = {
    {{-3, -4}, {5, -4}}, {{5, -4}, {5, 6}}, {{5, 6}, {-3, 6}}, {{-3, 6}, {-3, -4}}};

Eigen::Vector2d unit(double angle) { return {std::cos(angle), std::sin(angle)}; }

/// A laser that hovers at (0, 0) for the first second: ten perfect scans.
LaserModel perfectLaser() {
  LaserModel laser;
  laser.beams = 181;
  laser.angle_min = -kPi / 2.0;
  laser.angle_increment = kPi / 180.0;
  laser.rate_hz = 10.0;
  laser.range_max = 100.0;
  return laser;
}

FlightPath smallFlight() { return FlightPath({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, 0.5); }

TEST(Simulator, castsARayToAWall) {
  for (int degrees = -60; degrees <= 60; ++degrees) {
    const double angle = degToRad(degrees);
    EXPECT_NEAR(castRay(kWallAtFive, {0.0, 0.0}, unit(angle)), 5.0 / std::cos(angle), 1e-12);
  }
}

TEST(Simulator, missesWhatIsBehindBesideOrParallel) {
  EXPECT_TRUE(std::isinf(castRay(kWallAtFive, {0.0, 0.0}, {-1.0, 0.0})));
  EXPECT_TRUE(std::isinf(castRay(kWallAtFive, {0.0, 10.01}, {1.0, 0.0})));
  EXPECT_TRUE(std::isinf(castRay(kWallAtFive, {5.0, -20.0}, {0.0, 1.0})));
  EXPECT_TRUE(std::isinf(castRay({}, {0.0, 0.0}, {1.0, 0.0})));
  EXPECT_EQ(castRay(kWallAtFive, {0.0, 10.0}, {1.0, 0.0}), 5.0);  // the very end of the wall
}

TEST(Simulator, takesTheNearestOfSeveralWalls) {
  std::vector<Wall> walls = kWallAtFive;
  walls.push_back({{3.0, -1.0}, {3.0, 1.0}});
  walls.push_back({{8.0, -1.0}, {8.0, 1.0}});
  EXPECT_DOUBLE_EQ(castRay(walls, {0.0, 0.0}, {1.0, 0.0}), 3.0);
  EXPECT_DOUBLE_EQ(castRay(walls, {4.0, 0.0}, {1.0, 0.0}), 1.0);
}

TEST(Simulator, raysEndOnWallsOfAPolygonInEveryDirection) {
  // Seen from inside a circle's polygon of many sides, every ray is as long as the radius.
  constexpr int kSides = 3600;
  constexpr double kRadius = 7.0;
  std::vector<Wall> walls;
  for (int i = 0; i < kSides; ++i) {
    walls.push_back(
        {kRadius * unit(2.0 * kPi * i / kSides), kRadius * unit(2.0 * kPi * (i + 1) / kSides)});
  }
  std::mt19937_64 random(3);
  for (int i = 0; i < 500; ++i) {
    const double angle = static_cast<double>(random() % 100000) * 1e-4;
    EXPECT_NEAR(castRay(walls, {0.0, 0.0}, unit(angle)), kRadius, 1e-5);
  }
}

TEST(Simulator, perfectScansMatchTheWallExactly) {
  std::size_t compared = 0;
  for (const SimulatedScan& step : simulate(kWallAtFive, perfectLaser(), smallFlight(), 1)) {
    for (std::size_t i = 0; i < step.scan.ranges.size(); ++i) {
      const double angle = step.world_T_base.theta + degToRad(static_cast<double>(i) - 90.0);
      if (std::abs(std::remainder(angle, 2.0 * kPi)) > 1.0) continue;
      EXPECT_NEAR(step.scan.ranges[i], (5.0 - step.world_T_base.x) / std::cos(angle), 1e-5);
      ++compared;
    }
  }
  EXPECT_GT(compared, 1000U);
}

TEST(Simulator, stampsAndTruthFollowTheFlight) {
  const FlightPath path = smallFlight();
  const auto scans = simulate(kWallAtFive, perfectLaser(), path, 1);
  ASSERT_EQ(scans.size(), static_cast<std::size_t>(std::floor(path.duration() * 10.0)) + 1);
  EXPECT_EQ(scans[0].scan.stamp, kFlightStart);
  EXPECT_NEAR(scans[35].scan.stamp, kFlightStart + 3.5, 1e-6);
  EXPECT_EQ(scans[35].world_T_base, path.at(3.5));
}

TEST(Simulator, beamsOfASlowSweepSeeTheMovingLaser) {
  LaserModel laser = perfectLaser();
  laser.time_increment = 1e-3;
  const FlightPath path = smallFlight();
  const SimulatedScan step = simulate(kBox, laser, path, 1).at(30);
  for (const std::size_t i : {std::size_t{60}, std::size_t{90}, std::size_t{120}}) {
    const Pose2 pose = path.at(3.0 + static_cast<double>(i) * 1e-3);
    const double angle = pose.theta + degToRad(static_cast<double>(i) - 90.0);
    const Pose2& at_stamp = step.world_T_base;
    EXPECT_GT(std::abs(pose.theta - at_stamp.theta), 0.01);  // what the sweep has to show
    EXPECT_NEAR(step.scan.ranges[i], castRay(kBox, pose.translation(), unit(angle)), 1e-5);
  }
}

TEST(Simulator, noiseHasTheStatedMeanDeviationAndDropouts) {
  LaserModel laser = perfectLaser();
  laser.beams = 1;
  laser.angle_min = 0.0;
  laser.rate_hz = 50000.0;  // 50 000 readings in the second of hovering
  laser.sigma_m = 0.05;
  laser.dropout_probability = 0.1;
  const FlightPath path = smallFlight();
  const Pose2 start = path.at(0.0);
  const double distance = castRay(kWallAtFive, start.translation(), unit(start.theta));
  const auto scans = simulate(kWallAtFive, laser, path, 5);
  double sum = 0.0, squares = 0.0, dropouts = 0.0, readings = 0.0;
  for (std::size_t i = 0; i < 50000; ++i) {
    const double error = scans[i].scan.ranges[0] - distance;
    if (std::isnan(error)) {
      dropouts += 1.0;
      continue;
    }
    readings += 1.0;
    sum += error;
    squares += error * error;
  }
  EXPECT_NEAR(sum / readings, 0.0, 0.001);
  EXPECT_NEAR(std::sqrt(squares / readings), 0.05, 0.001);
  EXPECT_NEAR(dropouts / 50000.0, 0.1, 0.005);
}

TEST(Simulator, outOfRangeFollowsRep117) {
  LaserModel laser = perfectLaser();
  laser.angle_min = 0.0;
  laser.beams = 1;
  const FlightPath path = smallFlight();
  const Pose2 start = path.at(0.0);
  const double distance = castRay(kWallAtFive, start.translation(), unit(start.theta));
  laser.range_max = distance - 0.01;
  EXPECT_EQ(simulate(kWallAtFive, laser, path, 1)[0].scan.ranges[0], INFINITY);
  laser.range_max = distance + 0.02;
  laser.range_min = distance + 0.01;
  EXPECT_EQ(simulate(kWallAtFive, laser, path, 1)[0].scan.ranges[0], -INFINITY);
}

TEST(Simulator, sameSeedSameScansOtherSeedOtherScans) {
  const SimulatedWorld& world = simulatedWorld("laboratory");
  LaserModel laser = laserModel("sick180");
  laser.rate_hz = 1.0;
  const auto ranges = [&](std::uint64_t seed) {
    std::vector<float> all;
    for (const auto& step : simulate(world.walls, laser, world.flight(), seed)) {
      all.insert(all.end(), step.scan.ranges.begin(), step.scan.ranges.end());
    }
    return all;
  };
  const std::vector<float> first = ranges(1);
  EXPECT_EQ(first, ranges(1));
  EXPECT_NE(first, ranges(2));
}

TEST(Simulator, laboratoryIsTheLoopOfTwentyFiveMetres) {
  EXPECT_NEAR(simulatedWorld("laboratory").flight().length(), 25.0, 0.1);
  EXPECT_EQ(simulatedWorld("laboratory").speed_m_s, 0.5);
}

TEST(Simulator, flightsStayClearOfWalls) {
  constexpr double kClearance = 0.3;  // m, half a small quadrotor
  for (const SimulatedWorld& world : simulatedWorlds()) {
    const FlightPath path = world.flight();
    for (double time = 0.0; time < path.duration(); time += 0.1) {
      const Eigen::Vector2d position = path.at(time).translation();
      for (int degrees = 0; degrees < 360; degrees += 5) {
        ASSERT_GT(castRay(world.walls, position, unit(degToRad(degrees))), kClearance)
            << world.name << " after " << time << " s";
      }
    }
  }
}

TEST(Simulator, worldsAreClosed) {
  for (const SimulatedWorld& world : simulatedWorlds()) {
    const Eigen::Vector2d position = world.flight().at(0.0).translation();
    for (int i = 0; i < 7200; ++i) {
      ASSERT_TRUE(std::isfinite(castRay(world.walls, position, unit(degToRad(0.05 * i)))));
    }
  }
}

TEST(Simulator, sensorsAreTheNamedOnes) {
  const LaserModel& utm = laserModel("utm30lx");
  EXPECT_EQ(utm.beams, 1081);
  EXPECT_NEAR(utm.angle_min + (utm.beams - 1) * utm.angle_increment, degToRad(135.0), 1e-9);
  EXPECT_EQ(utm.rate_hz, 40.0);
  EXPECT_EQ(laserModel("sick180").beams, 180);
}

TEST(Simulator, unknownNamesAreAnsweredWithTheKnown) {
  try {
    simulatedWorld("moon");
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "unknown world 'moon'; there are laboratory, corridors");
  }
  EXPECT_THROW(laserModel(""), std::invalid_argument);
}

}  // namespace
}  // namespace kestrel_slam
