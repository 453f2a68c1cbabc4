// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/gyro_check.h"

#include <gtest/gtest.h>

#include "tracked_imu.h"

namespace kestrel {
namespace {

/// The readings of an IMU with a fault, checked one after the other.
class ImuCheckTest : public ::testing::Test {
 protected:
  using Change = std::function<void(ImuSample&)>;

  void feed(double duration, const Change& change) {
    const auto steps = std::lround(duration / kPeriod);
    for (long i = 0; i < steps; ++i, time_ += kPeriod) {
      true_ = trueSample(time_);
      ImuSample sample = true_;
      change(sample);
      checked_ = check_.check(sample, Eigen::Isometry3d::Identity());
      EXPECT_FALSE(checked_.fault) << checked_.fault->message;
    }
  }

  std::string reason() const {
    return checked_.contradiction ? checked_.contradiction->reason : "";
  }

  double time_ = 1000.0;
  ImuCheck check_;
  ImuSample true_;
  CheckedImu checked_;
};

void toDegrees(ImuSample& sample) { *sample.angular_velocity *= radToDeg(1.0); }

TEST_F(ImuCheckTest, AGoodImuIsNotChanged) {
  feed(60.0, [](ImuSample&) {});
  EXPECT_EQ(reason(), "");
  EXPECT_EQ(*checked_.sample.angular_velocity, *true_.angular_velocity);
  EXPECT_FALSE(checked_.converted);
}

TEST_F(ImuCheckTest, AGyroInDegreesIsConverted) {
  feed(1.0, toDegrees);
  EXPECT_EQ(reason(), "gyro in degrees");
  ASSERT_TRUE(checked_.sample.angular_velocity);
  EXPECT_LT((*checked_.sample.angular_velocity - *true_.angular_velocity).norm(), 1e-9);
}

TEST_F(ImuCheckTest, AGyroInDegreesIsNotUsedBeforeItIsConverted) {
  for (int i = 0; i < 300; ++i) {
    feed(kPeriod, toDegrees);
    if (!checked_.sample.angular_velocity) continue;
    // A single reading may pass before the orientation tells that it is wrong.
    EXPECT_TRUE(checked_.converted || i < 3) << i;
  }
}

TEST_F(ImuCheckTest, AGyroInDegreesIsConvertedInAFastTurnToo) {
  constexpr double kRate = 3.0;  // rad/s: more degrees per second than any gyro has rad/s
  for (int i = 0; i < 100; ++i) {
    ImuSample sample = trueSample(kPeriod * i);
    sample.world_R_imu = fromEuler(0.0, 0.0, kRate * kPeriod * i);
    sample.angular_velocity = Vector3d(0.0, 0.0, radToDeg(kRate));
    checked_ = check_.check(sample, Eigen::Isometry3d::Identity());
  }
  ASSERT_TRUE(checked_.converted);
  EXPECT_FALSE(checked_.fault);
  EXPECT_NEAR(checked_.sample.angular_velocity->z(), kRate, 1e-9);
}

TEST_F(ImuCheckTest, AGyroThatReadsZeroIsNotUsed) {
  feed(10.0, [](ImuSample& sample) { sample.angular_velocity->setZero(); });
  EXPECT_EQ(reason(), "gyro is zero");
  EXPECT_FALSE(checked_.sample.angular_velocity);
  EXPECT_TRUE(checked_.sample.world_R_imu);
}

TEST_F(ImuCheckTest, AnOrientationThatStandsStillIsNotUsed) {
  feed(10.0, [](ImuSample& sample) { sample.world_R_imu = Quaterniond::Identity(); });
  EXPECT_EQ(reason(), "orientation stands still");
  EXPECT_FALSE(checked_.sample.world_R_imu);
  EXPECT_TRUE(checked_.sample.angular_velocity);
}

TEST_F(ImuCheckTest, OppositeAndUnrelatedAxesAreSaid) {
  feed(20.0, [](ImuSample& sample) { *sample.angular_velocity *= -1.0; });
  EXPECT_NE(checked_.contradiction->message.find("opposite directions"), std::string::npos);
  check_.restart();
  feed(20.0, [](ImuSample& sample) {
    const Vector3d rate = *sample.angular_velocity;
    sample.angular_velocity = Vector3d(rate.z(), rate.y(), rate.x());
  });
  EXPECT_NE(checked_.contradiction->message.find("different axes"), std::string::npos);
}

TEST_F(ImuCheckTest, ADelayedOrientationIsNoFault) {
  // A filter delays the orientation of a vehicle that oscillates.
  const auto attitude = [](double t) { return fromEuler(0.1 * std::sin(6.0 * t), 0.0, 0.2 * t); };
  feed(60.0, [&](ImuSample& sample) {
    const double t = sample.stamp;
    const Eigen::AngleAxisd turn(attitude(t - 1e-4).conjugate() * attitude(t + 1e-4));
    sample.angular_velocity = turn.angle() / 2e-4 * turn.axis();
    sample.world_R_imu = attitude(t - 0.1);
    EXPECT_EQ(reason(), "") << t;
  });
}

TEST_F(ImuCheckTest, AnOrientationWithJumpsOfItsYawIsNoFault) {
  int i = 0;
  feed(60.0, [&](ImuSample& sample) {
    sample.world_R_imu = fromEuler(0.0, 0.0, ++i % 500 < 250 ? 0.0 : 0.5) * *sample.world_R_imu;
    EXPECT_EQ(reason(), "") << sample.stamp;
  });
}

}  // namespace
}  // namespace kestrel
