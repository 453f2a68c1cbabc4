// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/attitude_buffer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"
#include "sensor/tracked_imu.h"

namespace kestrel {
namespace {

Attitude lookUp(const AttitudeBuffer& buffer, double time) {
  Attitude attitude;
  EXPECT_EQ(buffer.lookup(time, attitude), AttitudeError::kNone) << "at " << time;
  return attitude;
}

TEST(AttitudeParts, YawAndTiltAreSeparated) {
  const Quaterniond q = fromEuler(0.2, -0.3, 2.0);
  EXPECT_NEAR(yawOf(q), 2.0, 1e-12);
  EXPECT_LT(withoutYaw(q).angularDistance(fromEuler(0.2, -0.3, 0.0)), 1e-12);
  EXPECT_NEAR(tiltOf(q), std::acos(std::cos(0.2) * std::cos(0.3)), 1e-12);
  EXPECT_NEAR(tiltOf(fromEuler(kPi, 0.0, 0.0)), kPi, 1e-12);
}

TEST(AttitudeBuffer, InterpolatesBetweenTwoAttitudes) {
  AttitudeBuffer buffer;
  ASSERT_TRUE(buffer.add(10.0, fromEuler(0.0, 0.0, 1.0), Vector3d::Zero()));
  ASSERT_TRUE(buffer.add(10.1, fromEuler(0.2, 0.0, 1.0), Vector3d::Zero()));
  const Attitude attitude = lookUp(buffer, 10.025);
  EXPECT_LT(attitude.stabilized_R_base.angularDistance(fromEuler(0.05, 0.0, 0.0)), 1e-9);
}

TEST(AttitudeBuffer, IntegratesTheGyroInsteadOfTheOrientation) {
  AttitudeBuffer buffer;
  // The rate grows from 0 to 2 rad/s in 1 s: 1 rad. The yaw of the quaternion jumps.
  for (int i = 0; i <= 100; ++i) {
    const double t = 0.01 * i;
    buffer.add(t, fromEuler(0.0, 0.0, 0.5 * (i % 3)), Vector3d(0.0, 0.0, 2.0 * t));
  }
  EXPECT_NEAR(lookUp(buffer, 1.0).integrated_yaw - lookUp(buffer, 0.0).integrated_yaw, 1.0, 1e-9);
  EXPECT_NEAR(lookUp(buffer, 0.505).integrated_yaw - lookUp(buffer, 0.0).integrated_yaw,
              0.505 * 0.505, 1e-9);
}

TEST(AttitudeBuffer, UsesTheYawOfTheOrientationWithoutAGyro) {
  AttitudeBuffer buffer;
  for (int i = 0; i <= 80; ++i) buffer.add(0.1 * i, fromEuler(0.0, 0.0, 0.1 * i), std::nullopt);
  EXPECT_NEAR(lookUp(buffer, 8.0).integrated_yaw - lookUp(buffer, 0.05).integrated_yaw, 7.95, 1e-9);
}

TEST(AttitudeBuffer, IntegratesTheYawRateOfATiltedBase) {
  // A tilted base that turns about the vertical at 1 rad/s.
  const Quaterniond tilt = fromEuler(0.3, -0.2, 0.0);
  AttitudeBuffer buffer;
  for (int i = 0; i <= 100; ++i) {
    const Quaterniond orientation = AngleAxisd(0.01 * i, Vector3d::UnitZ()) * tilt;
    buffer.add(0.01 * i, orientation, orientation.inverse() * Vector3d::UnitZ());
  }
  EXPECT_NEAR(lookUp(buffer, 1.0).integrated_yaw - lookUp(buffer, 0.0).integrated_yaw, 1.0, 1e-9);
}

TEST(AttitudeBuffer, SortsALateStamp) {
  AttitudeBuffer sorted, shuffled;
  const int order[] = {0, 2, 1, 4, 5, 3, 6};
  for (int i = 0; i <= 6; ++i) {
    sorted.add(0.1 * i, fromEuler(0.05 * i, 0.0, 0.0), Vector3d(0.5, 0.0, 0.1 * i));
    const int j = order[i];
    shuffled.add(0.1 * j, fromEuler(0.05 * j, 0.0, 0.0), Vector3d(0.5, 0.0, 0.1 * j));
  }
  for (double t = 0.0; t <= 0.6; t += 0.037) {
    const Attitude a = lookUp(sorted, t), b = lookUp(shuffled, t);
    EXPECT_LT(a.stabilized_R_base.angularDistance(b.stabilized_R_base), 1e-12);
    EXPECT_NEAR(a.integrated_yaw, b.integrated_yaw, 1e-12);
  }
}

TEST(AttitudeBuffer, ReportsWhyThereIsNoAttitude) {
  AttitudeBuffer buffer;
  Attitude attitude;
  EXPECT_EQ(buffer.lookup(1.0, attitude), AttitudeError::kEmpty);
  buffer.add(1.0, Quaterniond::Identity(), std::nullopt);
  buffer.add(1.1, Quaterniond::Identity(), std::nullopt);
  buffer.add(2.0, Quaterniond::Identity(), std::nullopt);
  EXPECT_EQ(buffer.lookup(0.9, attitude), AttitudeError::kTooOld);
  EXPECT_EQ(buffer.lookup(2.1, attitude), AttitudeError::kNotYet);
  EXPECT_EQ(buffer.lookup(1.5, attitude), AttitudeError::kGap);
  EXPECT_EQ(buffer.lookup(std::numeric_limits<double>::quiet_NaN(), attitude),
            AttitudeError::kTooOld);
  EXPECT_EQ(buffer.covers(1.0, 1.1), AttitudeError::kNone);
  EXPECT_EQ(buffer.covers(1.0, 2.0), AttitudeError::kGap);
  EXPECT_EQ(buffer.covers(1.05, 2.05), AttitudeError::kNotYet);
}

TEST(AttitudeBuffer, RefusesInvalidDuplicateAndOldAttitudes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  AttitudeBuffer buffer;
  EXPECT_TRUE(buffer.add(100.0, Quaterniond::Identity(), std::nullopt));
  EXPECT_FALSE(buffer.add(100.0, Quaterniond::Identity(), std::nullopt));
  EXPECT_FALSE(buffer.add(nan, Quaterniond::Identity(), std::nullopt));
  EXPECT_FALSE(buffer.add(100.1, Quaterniond(nan, 0, 0, 0), std::nullopt));
  EXPECT_FALSE(buffer.add(100.1, Quaterniond(0, 0, 0, 0), std::nullopt));
  EXPECT_FALSE(buffer.add(100.1, Quaterniond::Identity(), Vector3d(nan, 0, 0)));
  EXPECT_FALSE(buffer.add(80.0, Quaterniond::Identity(), std::nullopt));
  EXPECT_EQ(buffer.size(), 1U);
}

TEST(AttitudeBuffer, RemovesAttitudesOlderThanTheHistory) {
  AttitudeBuffer buffer;
  for (int i = 0; i < 10000; ++i) buffer.add(0.01 * i, Quaterniond::Identity(), Vector3d::UnitZ());
  EXPECT_LE(buffer.size(), 1001U);
  EXPECT_NEAR(*buffer.latest(), 99.99, 1e-9);
  // The integrated yaw continues although its first part is removed.
  EXPECT_NEAR(lookUp(buffer, *buffer.latest()).integrated_yaw, 99.99, 1e-6);
}

TEST(AttitudeBuffer, IntegratesTheHorizontalAcceleration) {
  // Tilted by 0.1 rad, the vehicle accelerates with 1.5 m/s² forward and turns at 1 rad/s.
  const Quaterniond tilt = fromEuler(0.0, 0.1, 0.0);
  const Vector3d force = tilt.inverse() * Vector3d(1.5, 0.0, 9.81);
  AttitudeBuffer buffer;
  for (int i = 0; i <= 200; ++i) {
    const double t = 0.005 * i;
    const Quaterniond orientation = AngleAxisd(t, Vector3d::UnitZ()) * tilt;
    buffer.add(t, orientation, orientation.inverse() * Vector3d::UnitZ(), force);
  }
  const Attitude a = lookUp(buffer, 0.0), b = lookUp(buffer, 1.0);
  ASSERT_TRUE(a.integrated_acceleration && b.integrated_acceleration);
  const Eigen::Vector2d gained = Eigen::Rotation2Dd(-a.integrated_yaw) *
                                 (*b.integrated_acceleration - *a.integrated_acceleration);
  EXPECT_NEAR(gained.x(), 1.5 * std::sin(1.0), 1e-4);  // the integral of 1.5 (cos t, sin t)
  EXPECT_NEAR(gained.y(), 1.5 * (1.0 - std::cos(1.0)), 1e-4);
}

TEST(AttitudeBuffer, IgnoresImplausibleAccelerations) {
  AttitudeBuffer buffer;
  for (const Vector3d& force : {Vector3d(0, 0, 1), Vector3d(0, 0, 1000)}) {  // unit g; broken
    buffer.add(static_cast<double>(buffer.size()), Quaterniond::Identity(), Vector3d::Zero(),
               force);
    EXPECT_FALSE(lookUp(buffer, *buffer.latest()).integrated_acceleration);
  }
}

TEST(AttitudeError, EveryErrorHasAText) {
  for (const AttitudeError error :
       {AttitudeError::kNone, AttitudeError::kEmpty, AttitudeError::kTooOld, AttitudeError::kNotYet,
        AttitudeError::kGap}) {
    EXPECT_STRNE(toString(error), "unknown");
  }
}

}  // namespace
}  // namespace kestrel
