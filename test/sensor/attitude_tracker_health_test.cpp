// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "kestrel_slam/sensor/attitude_tracker.h"
#include "tracked_imu.h"

namespace kestrel {
namespace {

using AttitudeTrackerHealth = AttitudeTrackerTest;

TEST_F(AttitudeTrackerHealth, DetectsASilentImu) {
  feed(1.0);
  EXPECT_EQ(tracker_.status(time_ + 0.4).health, ImuHealth::kOk);
  time_ += 0.9;
  expect(ImuHealth::kSilent, "0.91 s");
  expectRecovery();
  EXPECT_EQ(tracker_.status(0.0).health, ImuHealth::kOk)
      << "a clock behind the stamps is not a fault";
}

TEST_F(AttitudeTrackerHealth, DetectsAFrozenImu) {
  feed(1.0);
  const ImuSample stuck = trueSample(time_);
  const auto freeze = [&](ImuSample& sample) {
    const double stamp = sample.stamp;
    sample = stuck;
    sample.stamp = stamp;
  };
  EXPECT_EQ(feed(0.49, freeze), 49);
  expect(ImuHealth::kOk, "");
  EXPECT_LE(feed(1.0, freeze), 2);
  expect(ImuHealth::kFrozen, "the same reading");
  EXPECT_GE(status().rejected.at("frozen"), 98U);
  expectRecovery(kPeriod);
}

TEST_F(AttitudeTrackerHealth, ReadingsWithoutAnyValueAreNotCalledFrozen) {
  feed(2.0, [](ImuSample& sample) {
    sample.world_R_imu.reset();
    sample.angular_velocity.reset();
    sample.linear_acceleration.reset();
  });
  expect(ImuHealth::kInvalid, "neither an orientation nor an angular velocity");
}

TEST_F(AttitudeTrackerHealth, AConstantGyroIsNotFrozen) {
  EXPECT_EQ(feed(3.0, [](ImuSample& sample) { sample.angular_velocity = Vector3d::Zero(); }), 300);
  expect(ImuHealth::kOk, "");
}

TEST_F(AttitudeTrackerHealth, AcceptsAnOrientationWithoutOtherValues) {
  EXPECT_EQ(feed(3.0,
                 [](ImuSample& sample) {
                   sample.angular_velocity.reset();
                   sample.linear_acceleration.reset();
                 }),
            300);
  expectAttitude(1e-9);
}

/// Rotates the whole IMU without changing tf.
void turnImu(ImuSample& sample, const Quaterniond& imu_R_turned) {
  sample.world_R_imu = *sample.world_R_imu * imu_R_turned;
  sample.angular_velocity = imu_R_turned.conjugate() * *sample.angular_velocity;
  sample.linear_acceleration = imu_R_turned.conjugate() * *sample.linear_acceleration;
}

TEST_F(AttitudeTrackerHealth, DetectsAnUpsideDownImu) {
  for (const bool raw : {false, true}) {
    tracker_ = AttitudeTracker();
    const auto turn = [&](ImuSample& sample) {
      turnImu(sample, fromEuler(kPi, 0.0, 0.0));
      if (raw) makeRaw(sample);
    };
    feed(0.4, turn);
    EXPECT_EQ(status().health, ImuHealth::kOk) << "a short time is allowed for a flip";
    feed(0.5, turn);
    expect(ImuHealth::kUpsideDown, "degrees");
    expect(ImuHealth::kUpsideDown, "tf");
  }
  expectRecovery();
}

TEST_F(AttitudeTrackerHealth, DetectsAnImuOnItsSide) {
  feed(4.0, [](ImuSample& sample) { turnImu(sample, fromEuler(1.4, 0.0, 0.0)); });
  EXPECT_EQ(status().health, ImuHealth::kOk);
  feed(2.0, [](ImuSample& sample) { turnImu(sample, fromEuler(1.4, 0.0, 0.0)); });
  expect(ImuHealth::kContradiction, "lying on its side");
  expectRecovery();
}

TEST_F(AttitudeTrackerHealth, DetectsDisagreementOfOrientationAndAccelerometer) {
  const auto turn = [](double angle) {
    return [=](ImuSample& sample) {
      sample.linear_acceleration = fromEuler(angle, 0.0, 0.0) * *sample.linear_acceleration;
    };
  };
  feed(10.0, turn(degToRad(20.0)));
  expect(ImuHealth::kOk, "");
  feed(20.0, turn(degToRad(45.0)));
  expect(ImuHealth::kContradiction, "tf");
  const std::string before = "disagree by ", message = status().message;
  ASSERT_NE(message.find(before), std::string::npos) << message;
  EXPECT_NEAR(std::stod(message.substr(message.find(before) + before.size())), 45.0, 1.5);
  expectRecovery(20.0);
}

TEST_F(AttitudeTrackerHealth, AccelerationsInFlightAreNotAContradiction) {
  feed(30.0, [](ImuSample& sample) {
    const double push = 6.0 * std::sin(3.0 * sample.stamp);
    *sample.linear_acceleration +=
        sample.world_R_imu->conjugate() * Vector3d(push, -push, 0.5 * push);
  });
  expect(ImuHealth::kOk, "");
  EXPECT_EQ(status().message, "");
}

TEST_F(AttitudeTrackerHealth, DetectsGravityWithTheWrongSign) {
  const auto negate = [](ImuSample& sample) { *sample.linear_acceleration *= -1.0; };
  feed(5.0, negate);
  expect(ImuHealth::kContradiction, "wrong sign");
  tracker_ = AttitudeTracker();
  feed(5.0, [&](ImuSample& sample) {
    negate(sample);
    makeRaw(sample);
  });
  expect(ImuHealth::kUpsideDown, "wrong sign");
}

TEST_F(AttitudeTrackerHealth, DetectsAccelerationInUnitsOfG) {
  const auto scale = [](ImuSample& sample) { *sample.linear_acceleration /= kG; };
  EXPECT_EQ(feed(5.0, scale), 500) << "the orientation is still usable";
  expect(ImuHealth::kOk, "seems to be in g");
  tracker_ = AttitudeTracker();
  feed(5.0, [&](ImuSample& sample) {
    scale(sample);
    makeRaw(sample);
  });
  expect(ImuHealth::kInvalid, "1 m/s² instead of 9.81: it seems to be in g");
  EXPECT_EQ(tracker_.buffer().size(), 0U);
  EXPECT_GT(status().rejected.at("no gravity"), 400U);
}

}  // namespace
}  // namespace kestrel
