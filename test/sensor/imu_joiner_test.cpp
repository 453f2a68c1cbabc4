// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/imu_joiner.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

TEST(ImuJoiner, GyroReadingsGetTheInterpolatedSpecificForce) {
  ImuJoiner joiner;
  joiner.addAccelerometer(1.0, {0.0, 0.0, 9.0});
  joiner.addGyro(1.0, {0.1, 0.0, 0.0});
  joiner.addGyro(1.005, {0.2, 0.0, 0.0});
  ASSERT_EQ(joiner.take().size(), 1U) << "the second reading waits for the accelerometer";
  joiner.addGyro(1.015, {0.3, 0.0, 0.0});
  joiner.addAccelerometer(1.02, {0.0, 0.0, 11.0});
  const std::vector<ImuSample> samples = joiner.take();
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(samples[0].stamp, 1.005);
  EXPECT_EQ(samples[0].angular_velocity->x(), 0.2);
  EXPECT_NEAR(samples[0].linear_acceleration->z(), 9.5, 1e-9);
  EXPECT_NEAR(samples[1].linear_acceleration->z(), 10.5, 1e-9);
  EXPECT_FALSE(samples[0].world_R_imu);
}

TEST(ImuJoiner, ThereIsNoForceAcrossAGap) {
  ImuJoiner joiner;
  joiner.addGyro(0.9, {0.1, 0.0, 0.0});
  joiner.addAccelerometer(1.0, {0.0, 0.0, 9.0});
  joiner.addGyro(1.5, {0.1, 0.0, 0.0});
  joiner.addAccelerometer(2.0, {0.0, 0.0, 9.0});
  joiner.addGyro(2.1, {0.1, 0.0, 0.0});
  const std::vector<ImuSample> samples = joiner.take();
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_FALSE(samples[0].linear_acceleration);
  EXPECT_FALSE(samples[1].linear_acceleration);
  EXPECT_EQ(joiner.finish().size(), 1U);
}

}  // namespace
}  // namespace kestrel
