// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "filter_flight.h"

namespace kestrel {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A flight of 25 s on which something happens between 10 and 12 s.
class PoseFilterBadInput : public ::testing::Test {
 protected:
  static bool isBad(double time) { return time >= 10.0 && time < 12.0; }

  /// Feeds, and looks at every output: nothing that is not finite gets out.
  void fly() {
    feeding_.until_s = 25.0;
    feeding_.output = [&](double time, const FilterOutput& output) {
      EXPECT_TRUE(output.map_T_base.matrix().allFinite());
      EXPECT_TRUE(output.odom_T_base.matrix().allFinite());
      EXPECT_TRUE(output.velocity.allFinite());
      EXPECT_TRUE(output.covariance.allFinite());
      EXPECT_GE(output.covariance.diagonal().minCoeff(), 0.0);
      worst_m_ = time > 3.0 ? std::max(worst_m_, errorsOf(flight_, output).position_m) : 0.0;
    };
    feed(flight_, feeding_, filter_);
  }

  FilterStatus status(double time = 25.0) const {
    return filter_.status(flight_.start_stamp + time);
  }

  void expectGood(double position_m = 0.05) {
    ASSERT_TRUE(filter_.output());
    const FilterErrors errors = errorsOf(flight_, *filter_.output());
    EXPECT_LT(errors.position_m, position_m);
    EXPECT_LT(errors.velocity, 0.1);
    EXPECT_LT(errors.tilt_rad, 0.01);
    EXPECT_EQ(status().health, FilterHealth::kOk) << status().message;
  }

  FilterFlight flight_;
  Feeding feeding_;
  PoseFilter filter_;
  double worst_m_ = 0.0;
};

TEST_F(PoseFilterBadInput, NoImuAtAll) {
  EXPECT_EQ(status().health, FilterHealth::kNoImu);
  EXPECT_EQ(status().message, "no IMU sample has come yet");
  EXPECT_FALSE(filter_.at(0.0));
  EXPECT_TRUE(filter_.addPose(flight_.pose(1.0)));  // waits
}

TEST_F(PoseFilterBadInput, ImuNotFinite) {
  feeding_.imu = [](double time, ImuSample& sample) {
    if (isBad(time) && time < 10.5) sample.angular_velocity->y() = kNan;
    if (isBad(time) && time >= 10.5 && time < 10.8) sample.linear_acceleration->z() = kInfinity;
    return true;
  };
  fly();
  EXPECT_EQ(status().imu.rejected.at("not finite"), 80U);
  expectGood();
}

TEST_F(PoseFilterBadInput, ImuWithoutAccelerometerIsNamed) {
  feeding_.imu = [](double, ImuSample& sample) { return sample.linear_acceleration.reset(), true; };
  fly();
  EXPECT_FALSE(filter_.output());
  EXPECT_EQ(status().health, FilterHealth::kBadImu);
  EXPECT_EQ(status().imu.rejected.at("incomplete"), 2500U);
}

TEST_F(PoseFilterBadInput, ImuSaturated) {
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

TEST_F(PoseFilterBadInput, ImuFrozen) {
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

TEST_F(PoseFilterBadInput, ImuSilentForALittle) {
  feeding_.imu = [](double time, ImuSample&) { return time < 10.0 || time > 10.5; };
  fly();
  EXPECT_TRUE(status().resets.empty());
  expectGood();
}

TEST_F(PoseFilterBadInput, ImuSilentForLong) {
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

TEST_F(PoseFilterBadInput, GyroWithAConstantOffset) {
  feeding_.imu = [&](double, ImuSample& sample) {
    *sample.angular_velocity += Eigen::Vector3d(0.05, -0.05, 0.05);
    return true;
  };
  fly();
  expectGood();
  EXPECT_NEAR(filter_.output()->gyro_bias.z(), flight_.gyro_bias.z() + 0.05, 0.002);
}

/// Far beyond what any gyro does: the poses contradict it until the filter has found the bias.
TEST_F(PoseFilterBadInput, GyroWithAHugeConstantOffset) {
  feeding_.imu = [&](double, ImuSample& sample) {
    *sample.angular_velocity += Eigen::Vector3d(0.2, -0.2, 0.4);
    return true;
  };
  PoseFilterConfig config;
  config.max_gyro_bias = 1.0;
  filter_ = PoseFilter(config);
  fly();
  EXPECT_TRUE(status().started_in_air);  // no standstill has such a bias
  EXPECT_LT(errorsOf(flight_, *filter_.output()).position_m, 0.1);
  EXPECT_NEAR(filter_.output()->gyro_bias.z(), flight_.gyro_bias.z() + 0.4, 0.05);
}

TEST_F(PoseFilterBadInput, AnImpossibleGyroBiasNeverLooksHealthyForLong) {
  feeding_.imu = [&](double time, ImuSample& sample) {
    if (time > 10.0) *sample.angular_velocity += Eigen::Vector3d(0.0, 0.0, 3.0);
    return true;
  };
  fly();
  EXPECT_GT(status().resets.size() + status().reinitializations, 0U);
}

TEST_F(PoseFilterBadInput, AccelerometerWithAConstantOffset) {
  feeding_.imu = [](double, ImuSample& sample) {
    *sample.linear_acceleration += Eigen::Vector3d(0.3, 0.0, 0.5);
    return true;
  };
  fly();
  ASSERT_TRUE(filter_.output());
  EXPECT_LT(errorsOf(flight_, *filter_.output()).position_m, 0.1);
  EXPECT_NEAR(filter_.output()->accelerometer_bias.z(), 0.53, 0.02);
}

TEST_F(PoseFilterBadInput, ImuAt10HzIsSlowButTold) {
  feeding_.imu_hz = 10.0;
  feeding_.per_pose = 1;
  feeding_.per_range = 1;
  feeding_.pose_late_s = 0.1;
  fly();
  EXPECT_LT(worst_m_, 0.2);
  EXPECT_NE(status().message.find("10 Hz"), std::string::npos) << status().message;
}

TEST_F(PoseFilterBadInput, ImuAt2kHzIsThinned) {
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

TEST_F(PoseFilterBadInput, ImuOutOfOrder) {
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

TEST_F(PoseFilterBadInput, ClockSetBack) {
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

TEST_F(PoseFilterBadInput, WrongSignOfGravityIsNamed) {
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

TEST_F(PoseFilterBadInput, AccelerationInGIsNamed) {
  feeding_.imu = [](double, ImuSample& sample) {
    *sample.linear_acceleration /= 9.81;
    return true;
  };
  fly();
  EXPECT_FALSE(filter_.output());
  EXPECT_NE(status().message.find("check its unit"), std::string::npos) << status().message;
}

TEST_F(PoseFilterBadInput, PosesThatAreNone) {
  fly();
  PoseMeasurement pose = flight_.pose(24.99);
  const auto refuse = [&](const std::string& reason) {
    const auto counts = status().of(FilterSensor::kPose).rejected;
    const std::size_t before = counts.count(reason) > 0 ? counts.at(reason) : 0U;
    EXPECT_FALSE(filter_.addPose(pose)) << reason;
    EXPECT_EQ(status().of(FilterSensor::kPose).rejected.at(reason), before + 1U) << reason;
  };
  pose.covariance(0, 0) = -1.0;
  EXPECT_FALSE(filter_.addPose(pose));
  pose.covariance = Eigen::Matrix3d::Zero();
  EXPECT_FALSE(filter_.addPose(pose));
  pose.covariance << 1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0;  // indefinite
  EXPECT_FALSE(filter_.addPose(pose));
  pose.covariance << 1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0;  // not symmetric
  EXPECT_FALSE(filter_.addPose(pose));
  pose.covariance.setConstant(kNan);
  EXPECT_FALSE(filter_.addPose(pose));
  EXPECT_EQ(status().of(FilterSensor::kPose).rejected.at("covariance not positive definite"), 5U);
  pose = flight_.pose(24.99);
  pose.pose.x = kNan;
  refuse("not finite");
  pose = flight_.pose(24.99);
  pose.stamp -= 3600.0;
  refuse("too old");
  pose.stamp += 7200.0;
  refuse("from the future");
  pose.stamp = kNan;
  refuse("bad stamp");
  pose = flight_.pose(24.5);
  EXPECT_TRUE(filter_.addPose(pose));
  refuse("repeated");
  expectGood();
}

TEST_F(PoseFilterBadInput, WildPosesAreGated) {
  int i = 0;
  feeding_.pose = [&](double time, PoseMeasurement& pose) {
    if (time > 5.0 && ++i % 5 == 0) pose.pose = Pose2(3.0, -2.0, 1.0) * pose.pose;
    return true;
  };
  fly();
  EXPECT_GT(status().of(FilterSensor::kPose).rejected.at("innovation gate"), 90U);
  EXPECT_EQ(status().reinitializations, 0U);
  expectGood();
}

TEST_F(PoseFilterBadInput, HeightsThatAreNone) {
  fly();
  const double stamp = flight_.start_stamp + 24.99;
  for (const double height : {kNan, kInfinity, -kInfinity, -1.0, 0.0, 1e3}) {
    EXPECT_FALSE(filter_.addRange({stamp, height})) << height;
    EXPECT_FALSE(filter_.addFloorHeight({stamp, height})) << height;
  }
  EXPECT_FALSE(filter_.addBarometer({stamp, kNan}));
  EXPECT_FALSE(filter_.addYaw({stamp, kNan, 0.1}));
  EXPECT_FALSE(filter_.addPosition({stamp, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()}));
  expectGood();
}

TEST_F(PoseFilterBadInput, SingleSpikesOfTheRangeFinder) {
  int i = 0;
  feeding_.range = [&](double time, HeightSample& range) {
    if (time > 5.0 && ++i % 7 == 0) range.height_m = 3.0 + 0.5 * (i % 3);
    return true;
  };
  fly();
  EXPECT_GT(status().of(FilterSensor::kRange).rejected.at("step below"), 50U);
  EXPECT_EQ(filter_.output()->ground_m, 0.0);
  expectGood();
}

TEST_F(PoseFilterBadInput, Garbage) {
  Random random(11);
  const auto wild = [&] {
    const double kind = random.uniform();
    if (kind < 0.1) return kNan;
    if (kind < 0.2) return random.uniform() < 0.5 ? kInfinity : -kInfinity;
    return std::pow(10.0, 12.0 * random.uniform() - 6.0) * random.gaussian();
  };
  const auto vector = [&] { return Eigen::Vector3d(wild(), wild(), wild()); };
  feeding_.imu = [&](double time, ImuSample& sample) {
    if (!isBad(time)) return true;
    if (random.uniform() < 0.5) *sample.angular_velocity = vector();
    if (random.uniform() < 0.5) *sample.linear_acceleration = vector();
    filter_.addPose({sample.stamp + 0.1 * wild(), Pose2(wild(), wild(), wild()),
                     Eigen::Matrix3d(vector().asDiagonal())});
    filter_.addRange({sample.stamp + 0.1 * wild(), wild()});
    filter_.addBarometer({sample.stamp + 0.1 * wild(), wild()});
    filter_.addYaw({sample.stamp + 0.1 * wild(), wild(), wild()});
    filter_.addPosition({sample.stamp, vector(), Eigen::Matrix3d(vector().asDiagonal())});
    return true;
  };
  feeding_.until_s = 40.0;
  fly();
  EXPECT_TRUE(filter_.output() || status().health != FilterHealth::kOk);
}

}  // namespace
}  // namespace kestrel
