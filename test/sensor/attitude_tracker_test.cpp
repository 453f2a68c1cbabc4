// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/attitude_tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/geometry/random.h"
#include "tracked_imu.h"

namespace kestrel {
namespace {

TEST_F(AttitudeTrackerTest, ReportsThatNoReadingHasArrived) {
  expect(ImuHealth::kNoData, "no reading");
  EXPECT_EQ(tracker_.buffer().size(), 0U);
}

TEST_F(AttitudeTrackerTest, UsesTheOrientation) {
  EXPECT_EQ(feed(10.0), 1000);
  expect(ImuHealth::kOk, "");
  EXPECT_EQ(status().message, "");
  EXPECT_EQ(status().received, 1000U);
  EXPECT_EQ(status().used, 1000U);
  EXPECT_TRUE(status().rejected.empty());
  EXPECT_FALSE(status().estimated);
  expectAttitude(1e-9);
}

TEST_F(AttitudeTrackerTest, WorksWithAnyMounting) {
  for (const Quaterniond& base_R_imu :
       {fromEuler(kPi, 0.0, 0.0), fromEuler(0.5 * kPi, 0.0, 0.0), fromEuler(0.0, -0.5 * kPi, 1.0),
        fromEuler(-2.0, 0.7, 2.5)}) {
    for (const bool raw : {false, true}) {
      tracker_ = AttitudeTracker();
      base_R_imu_ = base_R_imu;
      EXPECT_EQ(feed(10.0,
                     [&](ImuSample& sample) {
                       if (raw) makeRaw(sample);
                     }),
                1000);
      expectAttitude(raw ? 1e-3 : 1e-9);
      expect(ImuHealth::kOk, "");
      EXPECT_EQ(status().estimated, raw);
      Attitude from, to;
      ASSERT_EQ(tracker_.buffer().lookup(time_ - 5.0, from), AttitudeError::kNone);
      ASSERT_EQ(tracker_.buffer().lookup(time_ - kPeriod, to), AttitudeError::kNone);
      const double turned = yawOf(trueAttitude(time_ - kPeriod)) - yawOf(trueAttitude(time_ - 5.0));
      EXPECT_NEAR(to.integrated_yaw - from.integrated_yaw, normalizeAngle(turned), 1e-3);
    }
  }
}

TEST_F(AttitudeTrackerTest, TheSourceParameterSelectsOrientationOrRaw) {
  AttitudeConfig config;
  config.source = "raw";
  tracker_ = AttitudeTracker(config);
  feed(5.0);
  EXPECT_TRUE(status().estimated);
  expectAttitude(1e-3);
  config.source = "orientation";
  tracker_ = AttitudeTracker(config);
  EXPECT_EQ(feed(1.0, makeRaw), 0);
  EXPECT_EQ(status().rejected.at("no orientation"), 100U);
  expect(ImuHealth::kInvalid, "no orientation");
}

TEST_F(AttitudeTrackerTest, ReportsMissingValues) {
  feed(1.0, [](ImuSample& sample) {
    makeRaw(sample);
    sample.angular_velocity.reset();
  });
  expect(ImuHealth::kInvalid, "angular velocity");
  EXPECT_EQ(status().rejected.at("no gyro"), 100U);
  feed(1.0, [](ImuSample& sample) {
    makeRaw(sample);
    sample.linear_acceleration.reset();
  });
  expect(ImuHealth::kInvalid, "acceleration");
  EXPECT_EQ(status().rejected.at("no accelerometer"), 100U);
  expectRecovery();
}

TEST_F(AttitudeTrackerTest, RejectsValuesThatAreNotFinite) {
  feed(1.0);
  const Change changes[] = {[](ImuSample& s) { s.world_R_imu->y() = kNan; },
                            [](ImuSample& s) { s.angular_velocity->z() = kInfinity; },
                            [](ImuSample& s) { s.linear_acceleration->x() = kNan; }};
  for (const Change& change : changes) {
    EXPECT_EQ(feed(0.2, change), 0);
    expect(ImuHealth::kInvalid, "not finite");
    expectRecovery();
  }
  EXPECT_EQ(status().rejected.at("not finite"), 60U);
}

TEST_F(AttitudeTrackerTest, RejectsInvalidStamps) {
  feed(1.0);
  for (const double stamp : {kNan, kInfinity, -kInfinity, 1e300}) {
    ImuSample sample = trueSample(time_);
    sample.stamp = stamp;
    EXPECT_FALSE(tracker_.add(sample, base_R_imu_));
  }
  EXPECT_EQ(status().rejected.at("bad stamp"), 4U);
  expect(ImuHealth::kInvalid, "stamp");
  expectRecovery();
}

TEST_F(AttitudeTrackerTest, RejectsQuaternionsThatAreNotUnit) {
  feed(1.0);
  for (const double norm : {0.0, 0.5, 0.94, 1.06, 3.0}) {
    EXPECT_EQ(feed(0.1, [&](ImuSample& s) { s.world_R_imu->coeffs() *= norm; }), 0) << norm;
    expect(ImuHealth::kInvalid, "instead of 1");
  }
  EXPECT_EQ(status().rejected.at("bad quaternion"), 50U);
  for (const double norm : {0.96, 1.04}) {
    EXPECT_EQ(feed(0.1, [&](ImuSample& s) { s.world_R_imu->coeffs() *= norm; }), 10) << norm;
    expectAttitude(1e-9);
  }
  ImuSample good = trueSample(time_);
  EXPECT_FALSE(tracker_.add(good, Quaterniond(0.0, 0.0, 0.0, 0.0)));
  EXPECT_FALSE(tracker_.add(good, Quaterniond(kNan, 0.0, 0.0, 0.0)));
  expectRecovery();
}

TEST_F(AttitudeTrackerTest, RejectsImpossibleValues) {
  feed(1.0);
  EXPECT_EQ(feed(0.1, [](ImuSample& s) { s.angular_velocity->x() = 1e200; }), 0);
  expect(ImuHealth::kInvalid, "rad/s is impossible");
  EXPECT_EQ(feed(0.1, [](ImuSample& s) { s.linear_acceleration->x() = -1e4; }), 0);
  expect(ImuHealth::kInvalid, "m/s² is impossible");
  expectRecovery();
}

TEST_F(AttitudeTrackerTest, SortsALateReading) {
  feed(1.0);
  time_ += kPeriod;  // one is late
  feed(0.05);
  EXPECT_TRUE(tracker_.add(trueSample(time_ - 6.0 * kPeriod), base_R_imu_));
  EXPECT_EQ(tracker_.buffer().size(), 106U);
  EXPECT_FALSE(tracker_.add(trueSample(time_ - 6.0 * kPeriod), base_R_imu_))
      << "a duplicate must be rejected";
  EXPECT_EQ(status().rejected.at("duplicate"), 1U);
  expectRecovery();
}

TEST_F(AttitudeTrackerTest, TheEstimatorRejectsALateReading) {
  feed(1.0, makeRaw);
  ImuSample late = trueSample(time_ - 5.5 * kPeriod);
  makeRaw(late);
  EXPECT_FALSE(tracker_.add(late, base_R_imu_));
  EXPECT_EQ(status().rejected.at("late"), 1U);
  EXPECT_EQ(feed(1.0, makeRaw), 100);
  expectAttitude(1e-3);
}

TEST_F(AttitudeTrackerTest, RejectsASingleStampThatJumps) {
  feed(1.0);
  for (const double shift : {-3600.0, -5.0, 5.0, 3600.0}) {
    EXPECT_FALSE(tracker_.add(trueSample(time_ + shift), base_R_imu_));
    expectRecovery();
  }
  EXPECT_EQ(status().rejected.at("stamp jumps"), 4U);
}

TEST_F(AttitudeTrackerTest, FollowsAClockThatWasSet) {
  feed(1.0);
  for (const double shift : {-60.0, 3600.0}) {
    time_ += shift;
    EXPECT_EQ(feed(0.5), 48) << "the first two stamps after the jump are rejected";
    EXPECT_EQ(tracker_.buffer().latest(), time_ - kPeriod);
    expectRecovery();
  }
}

TEST_F(AttitudeTrackerTest, RestartForgetsAllButTheCounters) {
  feed(1.0);
  tracker_.restart();
  EXPECT_EQ(tracker_.buffer().size(), 0U);
  EXPECT_EQ(status().received, 100U);
  time_ -= 500.0;
  EXPECT_EQ(feed(0.5), 50);
  expectRecovery();
}

TEST_F(AttitudeTrackerTest, AcceptsAttitudesFromAnotherSource) {
  for (int i = 0; i < 100; ++i, time_ += kPeriod) {
    EXPECT_TRUE(tracker_.addAttitude(time_, trueAttitude(time_)));
  }
  EXPECT_FALSE(tracker_.addAttitude(time_, Quaterniond(0.0, 0.0, 0.0, 0.0)));
  EXPECT_FALSE(tracker_.addAttitude(kNan, trueAttitude(time_)));
  expect(ImuHealth::kOk, "");
  expectAttitude(1e-9);
  EXPECT_EQ(status().used, 100U);
}

/// Mostly plausible numbers, sometimes arbitrary ones.
double anything(Random& random, double size) {
  constexpr double kShareOfGarbage = 0.02;
  if (random.uniform() > kShareOfGarbage) return random.uniform(-size, size);
  const double garbage[] = {kNan, kInfinity, -kInfinity, 0.0, 1e308, -1e308, 1e-308, 1e30, -1e11};
  return garbage[static_cast<std::size_t>(random.uniform(0.0, 9.0))];
}

TEST_F(AttitudeTrackerTest, GarbageNeverReachesTheBuffer) {
  Random random(7);
  const auto vector = [&](double size) {
    return Vector3d(anything(random, size), anything(random, size), anything(random, size));
  };
  for (int i = 0; i < 100000; ++i) {
    time_ += random.uniform() < 0.9 ? kPeriod : anything(random, 2.0);
    if (!(std::abs(time_) < 1e11)) time_ = 1000.0;
    ImuSample sample;
    sample.stamp = random.uniform() < 0.99 ? time_ : anything(random, 1e4);
    if (random.uniform() < 0.7) {
      sample.world_R_imu = Quaterniond(1.0, 0.1 * anything(random, 1.0), anything(random, 0.2),
                                       anything(random, 0.2));
    }
    if (random.uniform() < 0.9) sample.angular_velocity = vector(20.0);
    if (random.uniform() < 0.9) sample.linear_acceleration = vector(12.0);
    ASSERT_NO_THROW(tracker_.add(sample, Quaterniond(anything(random, 0.2), 1.0, 0.1, 0.0)));
    const std::optional<double> latest = tracker_.buffer().latest();
    if (!latest) continue;
    ASSERT_TRUE(std::isfinite(*latest));
    Attitude attitude;
    for (const double ago : {0.0, 0.5 * kPeriod, 0.3}) {
      if (tracker_.buffer().lookup(*latest - ago, attitude) != AttitudeError::kNone) continue;
      ASSERT_TRUE(attitude.stabilized_R_base.coeffs().allFinite()) << "reading " << i;
      ASSERT_NEAR(attitude.stabilized_R_base.norm(), 1.0, 1e-6);
      ASSERT_TRUE(std::isfinite(attitude.integrated_yaw)) << "reading " << i;
    }
  }
  EXPECT_GT(status().used, 20000U) << status().message;
  std::size_t rejected = 0;
  for (const auto& entry : status().rejected) rejected += entry.second;
  EXPECT_EQ(status().received, 100000U);
  EXPECT_EQ(status().used + rejected, status().received);
  time_ = 5e6;
  feed(20.0);
  expectRecovery();
}

}  // namespace
}  // namespace kestrel
