// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "bad_input_flight.h"

namespace kestrel {
namespace {

TEST_F(PoseFilterBadInput, ReportsAMissingImu) {
  EXPECT_EQ(status().health, FilterHealth::kNoImu);
  EXPECT_EQ(status().message, "no IMU sample yet");
  EXPECT_FALSE(filter_.at(0.0));
  EXPECT_TRUE(filter_.addPose(flight_.pose(1.0)));  // waits for the IMU
}

TEST_F(PoseFilterBadInput, RejectsImuSamplesThatAreNotFinite) {
  feeding_.imu = [](double time, ImuSample& sample) {
    if (isBad(time) && time < 10.5) sample.angular_velocity->y() = kNan;
    if (isBad(time) && time >= 10.5 && time < 10.8) sample.linear_acceleration->z() = kInfinity;
    return true;
  };
  fly();
  EXPECT_EQ(status().imu.rejected.at("not finite"), 80U);
  expectGood();
}

TEST_F(PoseFilterBadInput, ReportsAnImuWithoutAccelerometer) {
  feeding_.imu = [](double, ImuSample& sample) { return sample.linear_acceleration.reset(), true; };
  fly();
  EXPECT_FALSE(filter_.output());
  EXPECT_EQ(status().health, FilterHealth::kBadImu);
  EXPECT_EQ(status().imu.rejected.at("incomplete"), 2500U);
}

TEST_F(PoseFilterBadInput, SurvivesASaturatedImu) {
  PoseFilterConfig config;
  config.noise.gyro_range = 0.3;
  config.noise.accelerometer_range = 10.2;
  filter_ = PoseFilter(config);
  feeding_.imu = [](double, ImuSample& sample) {
    *sample.angular_velocity = sample.angular_velocity->cwiseMax(-0.3).cwiseMin(0.3);
    *sample.linear_acceleration = sample.linear_acceleration->cwiseMax(-10.2).cwiseMin(10.2);
    return true;
  };
  fly();
  EXPECT_LT(worst_m_, 0.1);
  EXPECT_TRUE(status().resets.empty());
}

TEST_F(PoseFilterBadInput, RecoversFromAFrozenImu) {
  ImuSample last;
  feeding_.imu = [&](double time, ImuSample& sample) {
    if (isBad(time)) {
      const double stamp = sample.stamp;
      sample = last;
      sample.stamp = stamp;
    } else {
      last = sample;
    }
    if (time > 11.9 && isBad(time)) {
      EXPECT_EQ(status(time).health, FilterHealth::kBadImu);
    }
    return true;
  };
  fly();
  EXPECT_GT(status().imu.rejected.at("frozen"), 140U);
  expectGood();
}

TEST_F(PoseFilterBadInput, BridgesAShortGapOfTheImu) {
  feeding_.imu = [](double time, ImuSample&) { return time < 10.0 || time > 10.5; };
  fly();
  EXPECT_TRUE(status().resets.empty());
  expectGood();
}

TEST_F(PoseFilterBadInput, InitializesAgainAfterALongGapOfTheImu) {
  feeding_.imu = [&](double time, ImuSample&) {
    if (isBad(time) && time > 10.5) {
      EXPECT_EQ(status(time).health, FilterHealth::kNoImu);
    }
    return !isBad(time);
  };
  fly();
  EXPECT_EQ(status().resets.at("gap of the IMU"), 1U);
  expectGood();
}

TEST_F(PoseFilterBadInput, EstimatesAConstantGyroOffset) {
  feeding_.imu = [&](double, ImuSample& sample) {
    *sample.angular_velocity += Eigen::Vector3d(0.05, -0.05, 0.05);
    return true;
  };
  fly();
  expectGood();
  EXPECT_NEAR(filter_.output()->gyro_bias.z(), flight_.gyro_bias.z() + 0.05, 0.002);
}

/// Much larger than the offset of any gyro. Poses are rejected until the filter has found the bias.
TEST_F(PoseFilterBadInput, EstimatesAHugeConstantGyroOffset) {
  feeding_.imu = [&](double, ImuSample& sample) {
    *sample.angular_velocity += Eigen::Vector3d(0.2, -0.2, 0.4);
    return true;
  };
  PoseFilterConfig config;
  config.max_gyro_bias = 1.0;
  filter_ = PoseFilter(config);
  fly();
  EXPECT_TRUE(status().started_in_air);  // such a bias is not accepted as a standstill
  EXPECT_LT(errorsOf(flight_, *filter_.output()).position_m, 0.1);
  EXPECT_NEAR(filter_.output()->gyro_bias.z(), flight_.gyro_bias.z() + 0.4, 0.05);
}

TEST_F(PoseFilterBadInput, DetectsAnImpossibleGyroBias) {
  feeding_.imu = [&](double time, ImuSample& sample) {
    if (time > 10.0) *sample.angular_velocity += Eigen::Vector3d(0.0, 0.0, 3.0);
    return true;
  };
  fly();
  EXPECT_GT(status().resets.size() + status().reinitializations, 0U);
}

TEST_F(PoseFilterBadInput, EstimatesAConstantAccelerometerOffset) {
  feeding_.imu = [](double, ImuSample& sample) {
    *sample.linear_acceleration += Eigen::Vector3d(0.3, 0.0, 0.5);
    return true;
  };
  fly();
  ASSERT_TRUE(filter_.output());
  EXPECT_LT(errorsOf(flight_, *filter_.output()).position_m, 0.1);
  EXPECT_NEAR(filter_.output()->accelerometer_bias.z(), 0.53, 0.02);
}

TEST_F(PoseFilterBadInput, ReportsASlowImu) {
  feeding_.imu_hz = 10.0;
  feeding_.per_pose = 1;
  feeding_.per_range = 1;
  feeding_.pose_late_s = 0.1;
  fly();
  EXPECT_LT(worst_m_, 0.2);
  EXPECT_NE(status().message.find("10 Hz"), std::string::npos) << status().message;
}

TEST_F(PoseFilterBadInput, AveragesAnImuAt2kHz) {
  feeding_.imu_hz = 2000.0;
  feeding_.per_pose = 80;
  feeding_.per_range = 100;
  feeding_.gyro_noise *= 4.0;
  feeding_.accelerometer_noise *= 4.0;
  fly();
  EXPECT_EQ(status().imu.accepted, 50000U);
  EXPECT_NEAR(status().imu_rate_hz, 2000.0, 20.0);
  expectGood();
}

TEST_F(PoseFilterBadInput, RejectsImuSamplesOutOfOrder) {
  std::optional<ImuSample> held;
  feeding_.imu = [&](double time, ImuSample& sample) {
    if (!isBad(time)) return true;
    if (held) {
      filter_.addImu(sample);
      sample = *held;
      held.reset();
      return true;
    }
    held = sample;
    return false;
  };
  fly();
  EXPECT_EQ(status().imu.rejected.at("late"), 100U);
  expectGood();
}

TEST_F(PoseFilterBadInput, FollowsAClockThatWasSetBack) {
  const double set_back = 500.0;
  feeding_.imu = [&](double time, ImuSample& sample) {
    if (time > 10.0) sample.stamp -= set_back;
    return true;
  };
  feeding_.pose = [&](double time, PoseMeasurement& pose) {
    if (time > 10.0) pose.stamp -= set_back;
    return true;
  };
  feeding_.range = [&](double time, HeightSample& range) {
    if (time > 10.0) range.stamp -= set_back;
    return true;
  };
  feeding_.until_s = 25.0;
  feed(flight_, feeding_, filter_);
  EXPECT_EQ(filter_.status(flight_.start_stamp + 25.0 - set_back).resets.at("clock set back"), 1U);
  FilterOutput output = *filter_.output();
  output.stamp += set_back;
  EXPECT_LT(errorsOf(flight_, output).position_m, 0.05);
}

TEST_F(PoseFilterBadInput, ReportsAWrongSignOfGravity) {
  feeding_.imu = [](double, ImuSample& sample) {
    *sample.linear_acceleration *= -1.0;
    return true;
  };
  fly();
  EXPECT_FALSE(filter_.output());
  EXPECT_EQ(status().health, FilterHealth::kBadImu);
  EXPECT_NE(status().message.find("gravity has the wrong sign"), std::string::npos)
      << status().message;
}

TEST_F(PoseFilterBadInput, ReportsAccelerationInUnitsOfG) {
  feeding_.imu = [](double, ImuSample& sample) {
    *sample.linear_acceleration /= 9.81;
    return true;
  };
  fly();
  EXPECT_FALSE(filter_.output());
  EXPECT_NE(status().message.find("check its unit"), std::string::npos) << status().message;
}

TEST_F(PoseFilterBadInput, StaysFiniteWithGarbage) {
  Random random(11);
  const auto randomValue = [&] {
    const double kind = random.uniform();
    if (kind < 0.1) return kNan;
    if (kind < 0.2) return random.uniform() < 0.5 ? kInfinity : -kInfinity;
    return std::pow(10.0, 12.0 * random.uniform() - 6.0) * random.gaussian();
  };
  const auto vector = [&] { return Eigen::Vector3d(randomValue(), randomValue(), randomValue()); };
  feeding_.imu = [&](double time, ImuSample& sample) {
    if (!isBad(time)) return true;
    if (random.uniform() < 0.5) *sample.angular_velocity = vector();
    if (random.uniform() < 0.5) *sample.linear_acceleration = vector();
    filter_.addPose({sample.stamp + 0.1 * randomValue(),
                     Pose2(randomValue(), randomValue(), randomValue()),
                     Eigen::Matrix3d(vector().asDiagonal())});
    filter_.addRange({sample.stamp + 0.1 * randomValue(), randomValue()});
    filter_.addBarometer({sample.stamp + 0.1 * randomValue(), randomValue()});
    filter_.addYaw({sample.stamp + 0.1 * randomValue(), randomValue(), randomValue()});
    filter_.addPosition({sample.stamp, vector(), Eigen::Matrix3d(vector().asDiagonal())});
    return true;
  };
  feeding_.until_s = 40.0;
  fly();
  EXPECT_TRUE(filter_.output() || status().health != FilterHealth::kOk);
}

}  // namespace
}  // namespace kestrel
