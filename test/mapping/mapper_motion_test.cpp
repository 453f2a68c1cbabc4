// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "kestrel_slam/mapping/mapper.h"
#include "room.h"

namespace kestrel {
namespace {

const std::vector<room::Segment> kSquare = {
    {-3, -3, 3, -3}, {3, -3, 3, 3}, {3, 3, -3, 3}, {-3, 3, -3, -3}};

PlanarScan turnedScan(double yaw, double time, const std::optional<double>& integrated_yaw) {
  PlanarScan scan = room::scanFrom(Pose2(0, 0, yaw), kSquare);
  scan.stamp = scan.time = time;
  scan.integrated_yaw = integrated_yaw;
  return scan;
}

TEST(MapperMotion, TheGyroResolvesRotationsThatTheScanCannot) {
  // A square room looks the same after a rotation by 90 degrees.
  Mapper with{MapperConfig()}, without{MapperConfig()};
  for (int i = 0; i < 9; ++i) {
    const double yaw = degToRad(90.0) * i, time = 0.4 * i;
    with.process(turnedScan(yaw, time, 100.0 + yaw));
    without.process(turnedScan(yaw, time, std::nullopt));
    EXPECT_NEAR(normalizeAngle(with.pose().yaw - yaw), 0.0, 1e-3) << i;
    EXPECT_NEAR(without.pose().yaw, 0.0, 1e-3) << i;
  }
}

TEST(MapperMotion, AWrongGyroDoesNotDistortTheMap) {
  Mapper mapper{MapperConfig()};
  for (int i = 0; i < 40; ++i) {
    PlanarScan scan = room::scanFrom(Pose2(0.02 * i, 0, 0.01 * i));
    scan.stamp = scan.time = 0.1 * i;
    scan.integrated_yaw = 0.3 * i;  // 30 times too fast
    const MapperResult result = mapper.process(scan);
    EXPECT_NEAR(result.pose.yaw, 0.01 * i, 0.01) << i;
    EXPECT_NEAR(result.pose.x, 0.02 * i, 0.03) << i;
  }
}

TEST(MapperMotion, IgnoresAnIntegratedYawThatIsNotFinite) {
  Mapper mapper{MapperConfig()};
  mapper.process(turnedScan(0.0, 0.0, std::numeric_limits<double>::quiet_NaN()));
  const MapperResult result =
      mapper.process(turnedScan(0.1, 0.1, std::numeric_limits<double>::infinity()));
  EXPECT_NEAR(result.pose.yaw, 0.1, 1e-3);
}

TEST(MapperMotion, VelocityIsInTheBaseFrame) {
  Mapper mapper{MapperConfig()};
  MapperResult result;
  for (int i = 0; i < 60; ++i) {  // 0.5 m/s along x of the map, nose along y
    PlanarScan scan = room::scanFrom(Pose2(-1.2 + 0.0125 * i, 0.3, degToRad(90.0)));
    scan.stamp = scan.time = 0.025 * i;
    if (i == 0) mapper.reset(Pose2(-1.2, 0.3, degToRad(90.0)));
    result = mapper.process(scan);
  }
  EXPECT_NEAR(result.velocity.x(), 0.0, 0.06);
  EXPECT_NEAR(result.velocity.y(), -0.5, 0.06);
  mapper.setPose(Pose2());
  PlanarScan scan = room::scanFrom(Pose2());
  scan.time = 2.0;
  EXPECT_EQ(mapper.process(scan).velocity, Eigen::Vector2d(0.0, 0.0));
}

TEST(MapperMotion, TheAccelerometerPredictsTheMotionAlongAnUnobservableDirection) {
  // In a corridor without visible ends the position along it is known only from the prediction. The
  // vehicle accelerates with 2 m/s² for 1 s and brakes again: 2 m.
  Mapper with{MapperConfig()}, without{MapperConfig()};
  MapperResult with_accelerometer, without_accelerometer;
  double x = 0.0, speed = 0.0;
  constexpr double kStep = 0.025, kAcceleration = 2.0;
  for (int i = 0; i <= 80; ++i) {
    PlanarScan scan = room::scanFrom(Pose2(x, 0, 0), room::corridor(), 720);
    scan.stamp = scan.time = kStep * i;
    scan.integrated_yaw = 0.0;
    without_accelerometer = without.process(scan);
    scan.integrated_acceleration = Eigen::Vector2d(speed, 0.0);
    with_accelerometer = with.process(scan);
    if (i == 80) break;
    const double acceleration = i < 40 ? kAcceleration : -kAcceleration;
    x += kStep * (speed + 0.5 * kStep * acceleration);
    speed += kStep * acceleration;
  }
  ASSERT_NEAR(x, 2.0, 1e-9);
  EXPECT_NEAR(with_accelerometer.pose.x, 2.0, 0.25);
  EXPECT_LT(without_accelerometer.pose.x, 1.0);
  EXPECT_NEAR(with_accelerometer.pose.y, 0.0, 0.02);
}

/// A scan from `seen` of a vehicle that stands still, as its IMU says.
PlanarScan scanOfStanding(const Pose2& seen, int number) {
  PlanarScan scan = room::scanFrom(seen);
  scan.stamp = scan.time = 0.025 * number;
  scan.integrated_yaw = 0.0;
  scan.integrated_acceleration = Eigen::Vector2d::Zero();
  return scan;
}

// What the laser sees moves away and comes back, as the floor in a tilt does.
TEST(MapperMotion, AMotionThatTheImuDoesNotShowIsSaid) {
  Mapper mapper{MapperConfig()};
  constexpr int kStart = 100, kTurn = 105, kEnd = 110;
  constexpr double kStep = 0.03;
  for (int i = 0; i < kEnd + 10; ++i) {
    const int away = i < kStart ? 0 : i < kTurn ? i - kStart : std::max(0, kEnd - i);
    const Pose2 seen(kStep * away, 0.0, 0.0);
    const MapperResult result = mapper.process(scanOfStanding(seen, i));
    EXPECT_LT(seen.between(result.pose).distance(), 0.01) << i;
    if (away > 3) {
      EXPECT_EQ(result.state, MatchState::kDegraded) << i;
      EXPECT_EQ(result.reason, std::string("IMU disagrees"));
      EXPECT_LT(seen.x, 3.0 * std::sqrt(result.covariance(0, 0))) << i;
    }
    EXPECT_TRUE(away > 0 || result.state == MatchState::kOk) << i;
  }
}

// An IMU that misses all motion, as one that is mounted loosely.
TEST(MapperMotion, AnImuThatIsOftenWrongSaysLittle) {
  Mapper mapper{MapperConfig()};
  int disagreeing = 0;
  for (int i = 0; i < 400; ++i) {
    const Pose2 pose(0.1 * std::sin(0.7 * i), 0.1 * std::cos(0.9 * i), 0.0);
    const bool disagrees = mapper.process(scanOfStanding(pose, i)).match.against_inertia;
    disagreeing += disagrees && i >= 350 ? 1 : 0;
  }
  EXPECT_LT(disagreeing, 3);
}

// A user knows better than the IMU where the vehicle is.
TEST(MapperMotion, AfterAPoseOfAUserTheImuBeginsThere) {
  Mapper mapper{MapperConfig()};
  for (int i = 0; i < 20; ++i) mapper.process(scanOfStanding(Pose2(), i));
  const Pose2 moved(0.4, 0.2, 0.0);
  mapper.setPose(moved);
  for (int i = 20; i < 25; ++i) {
    const MapperResult result = mapper.process(scanOfStanding(moved, i));
    EXPECT_FALSE(result.match.against_inertia) << i;
    EXPECT_LT(moved.between(result.pose).distance(), 0.03) << i;
  }
}

// A vehicle that hovers in gusts moves far enough for an insertion again and again.
TEST(MapperMotion, HoveringForALongTimeAddsNoScansToTheGraph) {
  MapperConfig config;
  config.window.enabled = true;
  Mapper mapper(config);
  int early = 0, late = 0;
  constexpr int kScans = 6000;
  for (int i = 0; i < kScans; ++i) {
    const double t = 0.1 * i;
    const Pose2 pose(0.3 * std::sin(1.1 * t) + 0.1 * std::sin(3.7 * t), 0.3 * std::sin(0.83 * t),
                     0.2 * std::sin(0.31 * t));
    PlanarScan scan = room::scanFrom(pose);
    scan.stamp = scan.time = t;
    const bool inserted = mapper.process(scan).inserted;
    (i < kScans / 2 ? early : late) += inserted ? 1 : 0;
  }
  EXPECT_GT(early, 10);
  EXPECT_LT(early, 60);
  EXPECT_LT(late, 5);
}

}  // namespace
}  // namespace kestrel
