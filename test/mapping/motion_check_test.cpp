// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/motion_check.h"

#include <gtest/gtest.h>

#include <string>

namespace kestrel {
namespace {

constexpr double kInterval = 0.025;  // s

/// A check that saw a vehicle with constant velocity (m/s) for one second. It was at 0 at the end.
MotionCheck movingWith(double velocity, double step = kInterval) {
  MotionCheck check;
  for (double time = -1.0; time <= 1e-9; time += step) check.add({time, {velocity * time, 0.0}});
  return check;
}

TEST(MotionCheck, AVehicleCanGoOnAndAccelerate) {
  const MotionCheck check = movingWith(2.0);
  EXPECT_FALSE(check.isImpossible({kInterval, {2.0 * kInterval, 0.0}}));
  EXPECT_FALSE(check.isImpossible({kInterval, {2.0 * kInterval + 0.01, -0.01}}));
  const double gained = 0.5 * 9.81 * 0.2 * 0.2;
  EXPECT_FALSE(check.isImpossible({0.2, {2.0 * 0.2 + gained, 0.0}}));
}

TEST(MotionCheck, AVehicleCannotJump) {
  const MotionCheck check = movingWith(2.0);
  EXPECT_TRUE(check.isImpossible({kInterval, {2.0 * kInterval + 0.05, 0.0}}));
  EXPECT_TRUE(check.isImpossible({kInterval, {2.0 * kInterval, 0.05}}));
  EXPECT_TRUE(check.isImpossible({kInterval, {-0.05, 0.0}}));
  EXPECT_TRUE(movingWith(0.0).isImpossible({kInterval, {0.05, 0.0}}));
}

TEST(MotionCheck, ACorrectionAlongACorridorIsNoMotion) {
  MotionCheck check = movingWith(1.0);
  EXPECT_FALSE(check.isImpossible({kInterval, {3.0, 0.0}, {1.0, 0.0}}));
  EXPECT_TRUE(check.isImpossible({kInterval, {3.0, 0.1}, {1.0, 0.0}}));
  check.add({kInterval, {kInterval, 0.0}, {1.0, 0.0}});
  EXPECT_FALSE(check.isImpossible({2.0 * kInterval, {3.0, 0.0}}));  // the corridor ends
  EXPECT_TRUE(check.isImpossible({2.0 * kInterval, {2.0 * kInterval, 0.05}}));
}

TEST(MotionCheck, BetweenScansThatAreFarApartMuchIsPossible) {
  EXPECT_FALSE(movingWith(1.0, 0.2).isImpossible({0.2, {0.5, 0.0}}));
}

TEST(MotionCheck, TheErrorsOfTwoLasersAreNoMotion) {
  const Eigen::Matrix2d covariance = Eigen::Vector2d(0.02 * 0.02, 0.003 * 0.003).asDiagonal();
  const auto check = [&](const std::string& other, const Eigen::Vector2d& position) {
    MotionCheck two;
    for (const double time : {-0.08, -0.04, 0.0})
      two.add({time, {0.0, 0.0}, {0.0, 0.0}, covariance, time == -0.04 ? other : "left"});
    return two.isImpossible({0.04, position, {0.0, 0.0}, covariance, other});
  };
  EXPECT_FALSE(check("right", {0.08, 0.0}));
  EXPECT_TRUE(check("left", {0.08, 0.0})) << "one laser keeps its error";
  EXPECT_TRUE(check("right", {0.0, 0.08})) << "the matches are more accurate across";
  EXPECT_TRUE(check("right", {0.3, 0.0}));
}

TEST(MotionCheck, TwoScansMayArriveAtOnce) {
  EXPECT_FALSE(movingWith(2.0).isImpossible({0.001, {2.0 * kInterval, 0.0}}));
}

TEST(MotionCheck, NothingIsKnownAtTheBeginning) {
  MotionCheck check;
  EXPECT_FALSE(check.isImpossible({0.0, {100.0, 0.0}}));
  check.add({0.0, {0.0, 0.0}});
  EXPECT_FALSE(check.isImpossible({kInterval, {100.0, 0.0}}));
  check = movingWith(1.0);
  check.clear();
  EXPECT_FALSE(check.isImpossible({kInterval, {100.0, 0.0}}));
}

TEST(MotionCheck, TimeThatGoesBackBeginsAgain) {
  MotionCheck check = movingWith(1.0);
  check.add({-5.0, {0.0, 0.0}});
  EXPECT_FALSE(check.isImpossible({-5.0 + kInterval, {100.0, 0.0}}));
  check.add({-5.0, {0.0, 0.0}});  // time stands still
  EXPECT_FALSE(check.isImpossible({-5.0 + kInterval, {100.0, 0.0}}));
}

}  // namespace
}  // namespace kestrel
