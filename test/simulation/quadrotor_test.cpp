// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/gravity.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/simulation/flight_plan.h"

namespace kestrel {
namespace {

constexpr double kWeight = 9.81;
constexpr std::uint64_t kSeed = 3;

FlightPlan square() {
  FlightPlan plan;
  plan.waypoints = {{{0, 0, 1}, 0.0, 0.0},
                    {{3, 0, 1}, 0.5, 0.0},
                    {{3, 3, 1.5}, 1.0, 0.0},
                    {{0, 3, 1}, 0.5, 0.0},
                    {{0, 0, 1}, 0.0, 0.0}};
  return plan;
}

/// Flights with full acceleration back and forth along both axes.
FlightPlan dashes() {
  FlightPlan plan;
  plan.smooth = false;
  plan.speed_m_s = 3.0;
  plan.acceleration_m_s2 = 3.6;
  plan.waypoints = {{{0, 0, 1}, 0.0, 0.0},
                    {{6, 0, 1}, 0.0, 0.0},
                    {{0, 0, 1}, 0.0, 0.0},
                    {{0, 6, 1}, 0.0, 0.0},
                    {{0, 0, 1}, 0.0, 0.0}};
  return plan;
}

QuadrotorConfig stillAir() {
  QuadrotorConfig config;
  config.gust_m_s2 = 0.0;
  return config;
}

double speedOf(const TrueState& state) { return state.velocity.norm(); }
double heightOf(const TrueState& state) { return state.world_T_base.translation().z(); }
double yawAt(const Motion& motion, double time) {
  return yawOf(Eigen::Quaterniond(motion.at(time).world_T_base.linear()));
}

/// Roll and pitch of R = Rz Ry Rx, rad.
Eigen::Vector2d rollPitch(const TrueState& state) {
  const Eigen::Matrix3d r = state.world_T_base.linear();
  return {std::atan2(r(2, 1), r(2, 2)), std::asin(-r(2, 0))};
}

template <typename Measure>
double largest(const Motion& motion, Measure measure) {
  double result = -std::numeric_limits<double>::infinity();
  for (double t = 0.0; t < motion.duration(); t += 0.01) {
    result = std::max(result, measure(motion.at(t)));
  }
  return result;
}

void expectConsistent(const Motion& motion) {
  constexpr double kStep = 1e-5;  // s
  for (double t = 0.0101; t < motion.duration() - 0.01; t += 0.0137) {
    const TrueState before = motion.at(t - kStep), now = motion.at(t), after = motion.at(t + kStep);
    const Eigen::Vector3d velocity =
        (after.world_T_base.translation() - before.world_T_base.translation()) / (2.0 * kStep);
    const Eigen::Vector3d acceleration = (after.velocity - before.velocity) / (2.0 * kStep);
    const Eigen::AngleAxisd turn(before.world_T_base.linear().transpose() *
                                 after.world_T_base.linear());
    const Eigen::Vector3d rate = turn.axis() * turn.angle() / (2.0 * kStep);
    ASSERT_LT((velocity - now.velocity).norm(), 1e-6) << t;
    ASSERT_LT((acceleration - now.acceleration).norm(), 1e-3) << t;
    ASSERT_LT((rate - now.angular_velocity).norm(), 1e-5) << t;
  }
}

TEST(Quadrotor, VelocitiesAndAccelerationsAreExactDerivatives) {
  expectConsistent(*flyQuadrotor(square(), QuadrotorConfig(), kSeed));
  expectConsistent(*flyQuadrotor(dashes(), QuadrotorConfig(), kSeed));
  QuadrotorConfig level;
  level.level = true;
  expectConsistent(*flyQuadrotor(dashes(), level, kSeed));
}

TEST(Quadrotor, WithoutWindTheSpecificForceIsAlongTheBodyAxis) {
  const auto motion = flyQuadrotor(dashes(), stillAir(), kSeed);
  double largest_horizontal = 0.0;
  for (double t = 0.0; t < motion->duration(); t += 0.01) {
    const TrueState state = motion->at(t);
    const Eigen::Vector3d specific_force = state.world_T_base.linear().transpose() *
                                           (state.acceleration + Eigen::Vector3d(0, 0, kWeight));
    ASSERT_LT(specific_force.head<2>().norm(), 2e-3) << t;
    largest_horizontal = std::max(largest_horizontal, state.acceleration.head<2>().norm());
  }
  EXPECT_GT(largest_horizontal, 3.0);
}

TEST(Quadrotor, IntegratedGyroAndAccelerometerGiveThePath) {
  const auto motion = flyQuadrotor(dashes(), QuadrotorConfig(), kSeed);
  constexpr double kStep = 1e-3;  // s
  TrueState state = motion->at(0.0);
  Eigen::Quaterniond attitude(state.world_T_base.linear());
  Eigen::Vector3d position = state.world_T_base.translation(), velocity = state.velocity;
  const auto steps = static_cast<int>(motion->duration() / kStep) - 1;
  for (int i = 0; i < steps; ++i) {
    const TrueState middle = motion->at((i + 0.5) * kStep);
    const Eigen::Vector3d accelerometer = middle.world_T_base.linear().transpose() *
                                          (middle.acceleration + Eigen::Vector3d(0, 0, kWeight));
    const Eigen::Vector3d half_turn = middle.angular_velocity * kStep / 2.0;
    const Eigen::Quaterniond half(Eigen::AngleAxisd(
        half_turn.norm(), half_turn.norm() > 0.0 ? Eigen::Vector3d(half_turn.normalized())
                                                 : Eigen::Vector3d::UnitX()));
    attitude = attitude * half;
    const Eigen::Vector3d acceleration = attitude * accelerometer - Eigen::Vector3d(0, 0, kWeight);
    attitude = attitude * half;
    position += velocity * kStep + acceleration * kStep * kStep / 2.0;
    velocity += acceleration * kStep;
  }
  const TrueState end = motion->at(steps * kStep);
  EXPECT_LT((position - end.world_T_base.translation()).norm(), 0.01);
  EXPECT_LT((velocity - end.velocity).norm(), 1e-3);
  EXPECT_LT(attitude.angularDistance(Eigen::Quaterniond(end.world_T_base.linear())), 1e-5);
}

TEST(Quadrotor, FastFlightReachesTwentyDegreesOfRollAndPitch) {
  const auto motion = flyQuadrotor(dashes(), stillAir(), kSeed);
  const double limit = degToRad(20.0), overshoot = degToRad(1.5);
  for (const int sign : {-1, 1}) {
    for (const int axis : {0, 1}) {
      const double angle =
          largest(*motion, [&](const TrueState& s) { return sign * rollPitch(s)[axis]; });
      EXPECT_NEAR(angle, limit, overshoot) << (axis == 0 ? "roll " : "pitch ") << sign;
    }
  }
  EXPECT_GT(largest(*motion, speedOf), 2.5);
}

TEST(Quadrotor, PitchesToAccelerateForwardAndRollsToAccelerateSideways) {
  const auto motion = flyQuadrotor(dashes(), stillAir(), kSeed);
  const TrueState forward = motion->at(1.4);  // accelerating, after a second of hovering
  EXPECT_GT(forward.acceleration.x(), 2.0);
  EXPECT_GT(rollPitch(forward).y(), degToRad(10.0));
  FlightPlan right = dashes();
  right.waypoints = {{{0, 0, 1}, 0.0, 0.0}, {{0, -6, 1}, 0.0, 0.0}};
  const TrueState sideways = flyQuadrotor(right, stillAir(), kSeed)->at(1.4);
  EXPECT_LT(sideways.acceleration.y(), -2.0);
  EXPECT_GT(rollPitch(sideways).x(), degToRad(10.0));
}

TEST(Quadrotor, BeginsAndEndsAtRestAtWaypoints) {
  const auto motion = flyQuadrotor(square(), QuadrotorConfig(), kSeed);
  for (const double t : {-3.0, 0.0}) {
    EXPECT_LT((motion->at(t).world_T_base.translation() - Eigen::Vector3d(0, 0, 1)).norm(), 1e-9);
    EXPECT_EQ(speedOf(motion->at(t)), 0.0);
  }
  EXPECT_LT(speedOf(motion->at(0.5)), 0.1);  // hovers
  const double end = motion->duration();
  EXPECT_LT((motion->at(end).world_T_base.translation() - Eigen::Vector3d(0, 0, 1)).norm(), 1e-3);
  EXPECT_LT(speedOf(motion->at(end - 1e-3)), 2e-4);
  EXPECT_EQ(speedOf(motion->at(end + 100.0)), 0.0);
  EXPECT_EQ(motion->at(end + 100.0).world_T_base.matrix(), motion->at(end).world_T_base.matrix());
}

TEST(Quadrotor, FliesAtTheGivenSpeedNearThePath) {
  FlightPlan plan;
  plan.waypoints = {{{0, 0, 1}, 0.0, 0.0}, {{10, 0, 1}, 0.0, 0.0}};
  plan.speed_m_s = 0.5;
  const auto motion = flyQuadrotor(plan, stillAir(), kSeed);
  // The flight consists of a second of hovering, an acceleration of 0.8 m/s², constant speed, the
  // same deceleration, and a second of hovering.
  const double ramps = 0.5 / 0.8;
  EXPECT_NEAR(speedOf(motion->at(1.0 + 10.0)), 0.5, 1e-3);
  EXPECT_NEAR(motion->at(1.0 + 10.0).world_T_base.translation().x(), 5.0 - ramps / 4.0, 0.01);
  EXPECT_GT(motion->duration(), 1.0 + 20.0 + ramps + 1.0);
  const auto windy = flyQuadrotor(plan, QuadrotorConfig(), kSeed);
  const double off = largest(*windy, [](const TrueState& state) {
    return std::hypot(state.world_T_base.translation().y(), heightOf(state) - 1.0);
  });
  EXPECT_GT(off, 0.01);  // the wind blows
  EXPECT_LT(off, 0.3);
}

TEST(Quadrotor, TurnsSeveralTimesAtTheGivenRate) {
  FlightPlan plan;
  plan.waypoints = {{{1, 2, 1}, 0.0, 0.0}, {{1, 2, 1}, 4.0 * kPi, 0.0}};
  plan.yaw_rate_rad_s = 2.0;
  const auto motion = flyQuadrotor(plan, stillAir(), kSeed);
  double turned = 0.0;
  for (double t = 0.0; t < motion->duration(); t += 0.01) {
    turned += normalizeAngle(yawAt(*motion, t + 0.01) - yawAt(*motion, t));
  }
  EXPECT_NEAR(turned, 4.0 * kPi, 1e-3);
  const double rate = largest(*motion, [](const TrueState& s) { return s.angular_velocity.z(); });
  EXPECT_NEAR(rate, 2.0, 0.01);
  EXPECT_NEAR(motion->at(5.0).angular_velocity.z(), 2.0, 0.01);
  EXPECT_LT(largest(*motion, speedOf), 1e-9);
}

TEST(Quadrotor, ClimbsAndDescends) {
  FlightPlan plan;
  plan.waypoints = {{{0, 0, 0.5}, 0.0, 1.0}, {{1, 0, 2.0}, 0.0, 1.0}, {{2, 0, 0.5}, 0.0, 0.0}};
  const auto motion = flyQuadrotor(plan, stillAir(), kSeed);
  EXPECT_NEAR(largest(*motion, heightOf), 2.0, 0.02);
  EXPECT_NEAR(heightOf(motion->at(motion->duration())), 0.5, 1e-3);
}

TEST(Quadrotor, YawFollowsThePath) {
  FlightPlan plan = square();
  plan.nose_forward = true;
  const auto motion = flyQuadrotor(plan, stillAir(), kSeed);
  std::size_t compared = 0;
  for (double t = 1.0; t < motion->duration(); t += 0.1) {
    const Eigen::Vector3d velocity = motion->at(t).velocity;
    if (velocity.head<2>().norm() < 0.4) continue;
    const double direction = std::atan2(velocity.y(), velocity.x());
    EXPECT_NEAR(normalizeAngle(yawAt(*motion, t) - direction), 0.0, 0.15) << t;
    ++compared;
  }
  EXPECT_GT(compared, 100U);
}

TEST(Quadrotor, RoundsCornersOrStopsAtThem) {
  FlightPlan plan = square();
  const Eigen::Vector3d corner = plan.waypoints[1].position;
  const auto nearest = [&](const Motion& motion) {
    return -largest(motion, [&](const TrueState& state) {
      return -(state.world_T_base.translation() - corner).norm();
    });
  };
  EXPECT_GT(nearest(*flyQuadrotor(plan, stillAir(), kSeed)), 0.3);
  plan.smooth = false;
  EXPECT_LT(nearest(*flyQuadrotor(plan, stillAir(), kSeed)), 0.02);
}

TEST(Quadrotor, LevelFlightHasTheSamePathWithoutTilt) {
  QuadrotorConfig level;
  level.level = true;
  const auto tilting = flyQuadrotor(dashes(), QuadrotorConfig(), kSeed);
  const auto upright = flyQuadrotor(dashes(), level, kSeed);
  ASSERT_EQ(tilting->duration(), upright->duration());
  for (double t = 0.0; t < tilting->duration(); t += 0.1) {
    const TrueState a = tilting->at(t), b = upright->at(t);
    EXPECT_EQ(a.world_T_base.translation(), b.world_T_base.translation());
    EXPECT_NEAR(normalizeAngle(yawAt(*tilting, t) - yawAt(*upright, t)), 0.0, 1e-12);
    EXPECT_LT(rollPitch(b).norm(), 1e-12);
  }
}

TEST(Quadrotor, GustsHaveTheGivenStrength) {
  FlightPlan plan;
  plan.waypoints = {{{0, 0, 1}, 0.0, 400.0}};
  QuadrotorConfig config;
  config.gust_m_s2 = 0.5;
  const auto motion = flyQuadrotor(plan, config, kSeed);
  // Horizontal specific force in the body frame is caused by wind only.
  double squares = 0.0, count = 0.0;
  for (double t = 2.0; t < 400.0; t += 0.05) {
    const TrueState state = motion->at(t);
    const Eigen::Vector3d force = state.world_T_base.linear().transpose() *
                                  (state.acceleration + Eigen::Vector3d(0, 0, kWeight));
    squares += force.head<2>().squaredNorm();
    count += 2.0;
  }
  EXPECT_NEAR(std::sqrt(squares / count), 0.5, 0.05);
}

TEST(Quadrotor, SeedDeterminesTheFlight) {
  const auto first = flyQuadrotor(square(), QuadrotorConfig(), 1);
  const auto same = flyQuadrotor(square(), QuadrotorConfig(), 1);
  const auto other = flyQuadrotor(square(), QuadrotorConfig(), 2);
  EXPECT_EQ(first->at(7.0).world_T_base.matrix(), same->at(7.0).world_T_base.matrix());
  EXPECT_NE(first->at(7.0).world_T_base.matrix(), other->at(7.0).world_T_base.matrix());
}

TEST(Quadrotor, RejectsInvalidPlansAndConfigs) {
  const auto refuses = [](const FlightPlan& plan, const QuadrotorConfig& config) {
    EXPECT_THROW(flyQuadrotor(plan, config, kSeed), std::invalid_argument);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refuses(FlightPlan(), QuadrotorConfig());
  FlightPlan plan = square();
  plan.speed_m_s = 0.0;
  refuses(plan, QuadrotorConfig());
  plan = square();
  plan.waypoints[2].position.y() = nan;
  refuses(plan, QuadrotorConfig());
  plan = square();
  plan.waypoints[1].hover_s = -1.0;
  refuses(plan, QuadrotorConfig());
  QuadrotorConfig config;
  config.max_tilt_rad = nan;
  refuses(square(), config);
}

TEST(Quadrotor, FliesUnusualPlans) {
  FlightPlan plan;
  plan.waypoints = {{{0, 0, 1}, 0.0, 0.0}};  // only hovers
  EXPECT_GE(flyQuadrotor(plan, stillAir(), kSeed)->duration(), 2.0);
  plan.waypoints = {{{0, 0, 1}, 0.0, 0.0}, {{0, 0, 1}, 0.0, 0.0}};  // the same place twice
  EXPECT_GE(flyQuadrotor(plan, stillAir(), kSeed)->duration(), 2.0);
  plan.waypoints = {{{0, 0, 1}, 0.0, 0.0}, {{2, 0, 1}, 0.0, 0.0}, {{0, 0, 1}, 0.0, 0.0}};
  plan.nose_forward = true;  // turns before the way back
  const auto motion = flyQuadrotor(plan, stillAir(), kSeed);
  EXPECT_LT(motion->at(motion->duration()).world_T_base.translation().head<2>().norm(), 1e-3);
  EXPECT_LT(largest(*motion, [](const TrueState& s) { return s.angular_velocity.norm(); }), 2.0);
}

}  // namespace
}  // namespace kestrel
