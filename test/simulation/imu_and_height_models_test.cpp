// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/gravity.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/simulation/flight_simulator.h"
#include "simulation/statistics.h"
#include "simulation/test_flight.h"

namespace kestrel {
namespace {

const Eigen::Vector3d kGravity(0.0, 0.0, 9.81);

class ImuAndHeightModelsTest : public testing::Test {
 protected:
  std::vector<ImuSample> imuOf(const Motion& motion, const ImuModel& imu,
                               std::uint64_t seed) const {
    return messagesOf<ImuSample>(simulateAll(world_, motion, onlyImu(imu), seed));
  }

  const World world_ = World(roomWithWalker());
  const KnownMotion motion_ = KnownMotion(4.0);
};

TEST_F(ImuAndHeightModelsTest, IdealImuMeasuresAngularVelocityAndSpecificForceInItsFrame) {
  // Mounted nose down and rotated, so that its axes differ from those of the base.
  const Eigen::Quaterniond base_R_imu(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(kPi / 2.0, Eigen::Vector3d::UnitY()));
  VehicleModel vehicle = onlyImu(idealImu());
  vehicle.base_R_imu = base_R_imu;
  const auto samples = messagesOf<ImuSample>(simulateAll(world_, motion_, vehicle, 1));
  ASSERT_EQ(samples.size(), 401U);
  for (const ImuSample& sample : samples) {
    const TrueState truth = motion_.at(sample.stamp - kFlightStart);
    const Eigen::Matrix3d world_R_imu = truth.world_T_base.linear() * base_R_imu.toRotationMatrix();
    EXPECT_LT((sample.world_R_imu->toRotationMatrix() - world_R_imu).norm(), 1e-6);
    EXPECT_LT((base_R_imu * *sample.angular_velocity - truth.angular_velocity).norm(), 1e-6);
    EXPECT_LT((world_R_imu * *sample.linear_acceleration - truth.acceleration - kGravity).norm(),
              1e-5);
  }
}

TEST_F(ImuAndHeightModelsTest, ImuNoiseIsItsDensityTimesTheRootOfTheRate) {
  ImuModel imu = idealImu();
  imu.rate_hz = 400.0;
  imu.gyro_noise = 0.001;
  imu.accelerometer_noise = 0.002;
  std::vector<double> gyro, accelerometer;
  for (const ImuSample& sample : imuOf(NoMotion(50.0), imu, 1)) {
    gyro.push_back(sample.angular_velocity->y());
    accelerometer.push_back(sample.linear_acceleration->z());
  }
  ASSERT_EQ(gyro.size(), 20001U);
  EXPECT_NEAR(deviationOf(gyro), 0.001 * 20.0, 0.0005);
  EXPECT_NEAR(deviationOf(accelerometer), 0.002 * 20.0, 0.001);
  EXPECT_NEAR(meanOf(gyro), 0.0, 0.001);
  EXPECT_NEAR(meanOf(accelerometer), 9.81, 0.002);
}

TEST_F(ImuAndHeightModelsTest, ImuBiasesAreRandomAtTheStartAndWalk) {
  ImuModel imu = idealImu();
  imu.gyro_bias = 0.01;
  imu.accelerometer_bias = 0.1;
  std::vector<double> gyro, accelerometer, walks;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const auto constant = imuOf(NoMotion(0.1), imu, seed);
    EXPECT_EQ(*constant.front().angular_velocity, *constant.back().angular_velocity);
    gyro.push_back(constant[0].angular_velocity->x());
    accelerometer.push_back(constant[0].linear_acceleration->x());
    ImuModel walking = idealImu();
    walking.gyro_bias_walk = 0.002;
    walks.push_back(imuOf(NoMotion(4.0), walking, seed).back().angular_velocity->x());
  }
  EXPECT_NEAR(deviationOf(gyro), 0.01, 0.001);
  EXPECT_NEAR(deviationOf(accelerometer), 0.1, 0.01);
  EXPECT_NEAR(deviationOf(walks), 0.002 * std::sqrt(4.0), 0.0004);
}

TEST_F(ImuAndHeightModelsTest, AttitudeErrorsHaveTheGivenDeviationAndCorrelationTime) {
  ImuModel imu = idealImu();
  imu.rate_hz = 10.0;
  imu.attitude_sigma_rad = 0.01;
  imu.attitude_time_s = 2.0;
  imu.yaw_sigma_rad = 0.05;
  std::vector<double> rolls, yaws;
  for (const ImuSample& sample : imuOf(NoMotion(8000.0), imu, 1)) {
    const Eigen::Matrix3d r = sample.world_R_imu->toRotationMatrix();
    rolls.push_back(std::atan2(r(2, 1), r(2, 2)));
    yaws.push_back(yawOf(*sample.world_R_imu));
  }
  EXPECT_NEAR(deviationOf(rolls), 0.01, 0.0006);
  EXPECT_NEAR(deviationOf(yaws), 0.05, 0.003);
  // Neighbors have the correlation exp(-0.1 / 2), which determines their difference.
  EXPECT_NEAR(noiseOf(rolls), 0.01 * std::sqrt(1.0 - std::exp(-0.05)), 0.0003);
}

TEST_F(ImuAndHeightModelsTest, MisalignmentRotatesAllMeasurementsOfAnImu) {
  ImuModel imu = idealImu();
  imu.misalignment_rad = 0.02;
  std::vector<double> tilts;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const ImuSample sample = imuOf(NoMotion(0.0), imu, seed).at(0);
    tilts.push_back(sample.linear_acceleration->y() / 9.81);
    const Eigen::Vector3d down = sample.world_R_imu->conjugate() * kGravity;
    EXPECT_LT((down - *sample.linear_acceleration).norm(),
              1e-9);  // the same misalignment for both sensors
  }
  EXPECT_NEAR(deviationOf(tilts), 0.02, 0.002);
}

TEST_F(ImuAndHeightModelsTest, RawImuGivesNoOrientation) {
  ImuModel imu;
  imu.gives_orientation = false;
  const ImuSample raw = imuOf(motion_, imu, 1).at(7);
  imu.gives_orientation = true;
  const ImuSample full = imuOf(motion_, imu, 1).at(7);
  EXPECT_FALSE(raw.world_R_imu.has_value());
  EXPECT_EQ(*raw.angular_velocity, *full.angular_velocity);
}

TEST_F(ImuAndHeightModelsTest, RangeFinderAndBarometerHaveTheGivenErrors) {
  VehicleModel vehicle;
  vehicle.barometer->drift_m_per_sqrt_s = 0.0;
  std::vector<double> ranges, heights;
  const auto events = simulateAll(world_, NoMotion(300.0), vehicle, 1);
  for (const auto& sample : messagesOf<HeightSample>(events)) ranges.push_back(sample.height_m);
  for (const auto& b : messagesOf<Barometer>(events)) heights.push_back(b.sample.height_m);
  EXPECT_NEAR(meanOf(ranges), 1.0, 0.001);
  EXPECT_NEAR(deviationOf(ranges), 0.01, 0.0005);
  EXPECT_NEAR(meanOf(heights), 1.0, 0.01);
  EXPECT_NEAR(deviationOf(heights), 0.1, 0.006);

  vehicle.barometer->drift_m_per_sqrt_s = 0.2;
  std::vector<double> drifts;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    VehicleModel only = onlyImu(idealImu());
    only.barometer = vehicle.barometer;
    only.barometer->sigma_m = 0.0;
    const auto readings = messagesOf<Barometer>(simulateAll(world_, NoMotion(9.0), only, seed));
    drifts.push_back(readings.back().sample.height_m - 1.0);
  }
  EXPECT_NEAR(deviationOf(drifts), 0.2 * 3.0, 0.08);
}

TEST_F(ImuAndHeightModelsTest, RangesOutOfRangeFollowRep117) {
  VehicleModel vehicle;
  vehicle.range_finder->range_max = 0.9;  // the floor is at 1 m
  const NoMotion still(1.0);
  for (const auto& sample : messagesOf<HeightSample>(simulateAll(world_, still, vehicle, 1))) {
    EXPECT_EQ(sample.height_m, INFINITY);
  }
  vehicle.range_finder->range_max = 6.0;
  vehicle.range_finder->range_min = 1.5;
  for (const auto& sample : messagesOf<HeightSample>(simulateAll(world_, still, vehicle, 1))) {
    EXPECT_EQ(sample.height_m, -INFINITY);
  }
}

}  // namespace
}  // namespace kestrel
