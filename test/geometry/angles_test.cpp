// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/geometry/angles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kestrel {
namespace {

TEST(Angles, KeepsWhatIsInTheInterval) {
  for (const double angle : {0.0, 1e-10, -1e-10, 1.0, -1.0, 3.1415, -3.1415, kPi}) {
    EXPECT_EQ(normalizeAngle(angle), angle);
  }
}

TEST(Angles, MinusPiBecomesPi) {
  EXPECT_EQ(normalizeAngle(-kPi), kPi);
  EXPECT_DOUBLE_EQ(normalizeAngle(3.0 * kPi), kPi);
  EXPECT_DOUBLE_EQ(normalizeAngle(-3.0 * kPi), kPi);
}

TEST(Angles, WrapsAcrossThePole) {
  EXPECT_NEAR(normalizeAngle(kPi + 0.1), -kPi + 0.1, 1e-15);
  EXPECT_NEAR(normalizeAngle(-kPi - 0.1), kPi - 0.1, 1e-15);
  EXPECT_NEAR(normalizeAngle(2.0 * kPi), 0.0, 1e-15);
  EXPECT_NEAR(normalizeAngle(7.5), 7.5 - 2.0 * kPi, 1e-15);
}

TEST(Angles, PointsTheSameWayForAnyAngle) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angles(-1000.0, 1000.0);
  for (int i = 0; i < 10000; ++i) {
    const double angle = angles(random);
    const double wrapped = normalizeAngle(angle);
    EXPECT_GT(wrapped, -kPi);
    EXPECT_LE(wrapped, kPi);
    EXPECT_NEAR(std::cos(wrapped), std::cos(angle), 1e-12);
    EXPECT_NEAR(std::sin(wrapped), std::sin(angle), 1e-12);
  }
}

TEST(Angles, ConvertsDegrees) {
  EXPECT_EQ(degToRad(180.0), kPi);
  EXPECT_DOUBLE_EQ(degToRad(-90.0), -kPi / 2.0);
  EXPECT_EQ(radToDeg(kPi), 180.0);
  EXPECT_DOUBLE_EQ(radToDeg(degToRad(12.5)), 12.5);
}

}  // namespace
}  // namespace kestrel
