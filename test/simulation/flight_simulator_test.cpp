#include "kestrel_slam/simulation/flight_simulator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "simulation/test_flight.h"

namespace kestrel_slam {
namespace {

const Eigen::Vector3d kGravity(0.0, 0.0, 9.81);

std::vector<std::size_t> countsByType(const std::vector<FlightEvent>& events) {
  std::vector<std::size_t> counts(std::variant_size_v<FlightMessage>);
  for (const FlightEvent& event : events) ++counts[event.message.index()];
  return counts;
}

double meanOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double deviationOf(const std::vector<double>& values) {
  const double mean = meanOf(values);
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

/// Noise without what wanders slowly: deviation of the differences of neighbours.
double noiseOf(const std::vector<double>& values) {
  std::vector<double> differences;
  for (std::size_t i = 1; i < values.size(); ++i) differences.push_back(values[i] - values[i - 1]);
  return deviationOf(differences) / std::sqrt(2.0);
}

class FlightSimulatorTest : public testing::Test {
 protected:
  std::vector<ImuSample> imuOf(const Motion& motion, const ImuModel& imu,
                               std::uint64_t seed) const {
    return messagesOf<ImuSample>(simulateAll(world_, motion, onlyImu(imu), seed));
  }

  const World world_ = World(roomWithWalker());
  const KnownMotion motion_ = KnownMotion(4.0);
};

TEST_F(FlightSimulatorTest, everySensorSendsAtItsRateFromTheStartToTheEnd) {
  const auto counts = countsByType(simulateAll(world_, motion_, smallVehicle(), 1));
  const std::vector<std::size_t> expected = {39, 19, 401, 81, 41, 401, 41};
  EXPECT_EQ(counts, expected);  // laser, lidar, IMU, range finder, barometer, truth, walkers
}

TEST_F(FlightSimulatorTest, messagesComeInTheOrderOfTheirArrival) {
  const auto events = simulateAll(world_, motion_, smallVehicle(), 1);
  EXPECT_EQ(events.front().arrival, kFlightStart);
  for (std::size_t i = 1; i < events.size(); ++i) {
    ASSERT_LE(events[i - 1].arrival, events[i].arrival);
  }
}

TEST_F(FlightSimulatorTest, latencyIsThatOfTheSensorAfterItsSweep) {
  constexpr double kRounding = 1e-6;  // of stamps of 1.4e9 s
  for (const FlightEvent& event : simulateAll(world_, motion_, smallVehicle(), 1)) {
    const std::vector<double> expected = {0.0091 + 0.005, 0.2 + 0.005, 0.005, 0.01, 0.02, 0.0, 0.0};
    ASSERT_NEAR(event.arrival - event.stamp, expected[event.message.index()], kRounding)
        << event.message.index();
  }
}

TEST_F(FlightSimulatorTest, stampsInsideOfMessagesAreThoseOfTheEvents) {
  for (const FlightEvent& event : simulateAll(world_, motion_, smallVehicle(), 1)) {
    if (const auto* scan = std::get_if<LaserScan>(&event.message)) {
      ASSERT_EQ(scan->stamp, event.stamp);
    } else if (const auto* cloud = std::get_if<PointCloud>(&event.message)) {
      ASSERT_EQ(cloud->stamp, event.stamp);
    } else if (const auto* imu = std::get_if<ImuSample>(&event.message)) {
      ASSERT_EQ(imu->stamp, event.stamp);
    } else if (const auto* height = std::get_if<HeightSample>(&event.message)) {
      ASSERT_EQ(height->stamp, event.stamp);
    } else if (const auto* barometer = std::get_if<Barometer>(&event.message)) {
      ASSERT_EQ(barometer->sample.stamp, event.stamp);
    }
  }
}

TEST_F(FlightSimulatorTest, truthIsTheMotionAtItsStamp) {
  std::size_t walkers = 0;
  for (const FlightEvent& event : simulateAll(world_, motion_, smallVehicle(), 1)) {
    const double time = event.stamp - kFlightStart;
    if (const auto* pose = std::get_if<TruePose>(&event.message)) {
      ASSERT_LT((pose->state.velocity - motion_.at(time).velocity).norm(), 1e-5);
    } else if (const auto* people = std::get_if<TrueWalkers>(&event.message)) {
      ASSERT_EQ(people->positions.size(), 1U);
      ASSERT_LT((people->positions[0] - world_.parts().walkers[0].at(time)).norm(), 1e-5);
      ++walkers;
    }
  }
  EXPECT_EQ(walkers, 41U);
}

TEST_F(FlightSimulatorTest, anIdealImuMeasuresTurnRateAndSpecificForceInItsOwnFrame) {
  // Mounted nose down and turned: its axes are not those of the base.
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

TEST_F(FlightSimulatorTest, imuNoiseIsItsDensityTimesTheRootOfTheRate) {
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

TEST_F(FlightSimulatorTest, imuBiasesAreDrawnOnceAndWalk) {
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

TEST_F(FlightSimulatorTest, attitudeErrorsWanderAboutTheGivenDeviation) {
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
  // exp(-0.1 / 2) is the correlation of neighbours: they differ by sqrt(1 - correlation).
  EXPECT_NEAR(noiseOf(rolls), 0.01 * std::sqrt(1.0 - std::exp(-0.05)), 0.0003);
}

TEST_F(FlightSimulatorTest, misalignmentTurnsAllThatAnImuMeasures) {
  ImuModel imu = idealImu();
  imu.misalignment_rad = 0.02;
  std::vector<double> tilts;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const ImuSample sample = imuOf(NoMotion(0.0), imu, seed).at(0);
    tilts.push_back(sample.linear_acceleration->y() / 9.81);
    const Eigen::Vector3d down = sample.world_R_imu->conjugate() * kGravity;
    EXPECT_LT((down - *sample.linear_acceleration).norm(), 1e-9);  // one and the same box
  }
  EXPECT_NEAR(deviationOf(tilts), 0.02, 0.002);
}

TEST_F(FlightSimulatorTest, aRawImuGivesNoOrientation) {
  ImuModel imu;
  imu.gives_orientation = false;
  const ImuSample raw = imuOf(motion_, imu, 1).at(7);
  imu.gives_orientation = true;
  const ImuSample full = imuOf(motion_, imu, 1).at(7);
  EXPECT_FALSE(raw.world_R_imu.has_value());
  EXPECT_EQ(*raw.angular_velocity, *full.angular_velocity);
}

TEST_F(FlightSimulatorTest, rangeFinderAndBarometerHaveTheirErrors) {
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

TEST_F(FlightSimulatorTest, rangesOutOfRangeFollowRep117) {
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

TEST_F(FlightSimulatorTest, jitterIsInTheStampsAndNotInWhatIsMeasured) {
  VehicleModel vehicle = smallVehicle();
  const auto clean = simulateAll(world_, motion_, vehicle, 1);
  vehicle.stamp_jitter_s = 0.002;
  const auto jittered = simulateAll(world_, motion_, vehicle, 1);
  ASSERT_EQ(clean.size(), jittered.size());
  std::vector<double> errors;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    ASSERT_EQ(clean[i].message.index(), jittered[i].message.index());
    EXPECT_EQ(clean[i].arrival, jittered[i].arrival);
    if (const auto* imu = std::get_if<ImuSample>(&clean[i].message)) {
      errors.push_back(jittered[i].stamp - clean[i].stamp);
      EXPECT_EQ(*imu->angular_velocity, *std::get<ImuSample>(jittered[i].message).angular_velocity);
    } else if (std::holds_alternative<TruePose>(clean[i].message)) {
      EXPECT_EQ(clean[i].stamp, jittered[i].stamp);
    }
  }
  EXPECT_NEAR(deviationOf(errors), 0.002, 0.0003);
}

TEST_F(FlightSimulatorTest, lostMessagesAreMissingAndTheOthersUnchanged) {
  VehicleModel vehicle = smallVehicle();
  std::map<double, LaserScan> all;
  for (const auto& scan : messagesOf<LaserScan>(simulateAll(world_, motion_, vehicle, 1))) {
    all[scan.stamp] = scan;
  }
  vehicle.loss_probability = 0.3;
  const auto lossy = simulateAll(world_, motion_, vehicle, 1);
  EXPECT_NEAR(static_cast<double>(messagesOf<ImuSample>(lossy).size()), 0.7 * 401.0, 30.0);
  EXPECT_EQ(messagesOf<TruePose>(lossy).size(), 401U);
  const auto scans = messagesOf<LaserScan>(lossy);
  EXPECT_LT(scans.size(), all.size());
  for (const LaserScan& scan : scans) EXPECT_EQ(scan.ranges, all.at(scan.stamp).ranges);
  vehicle.loss_probability = 1.0;
  const auto counts = countsByType(simulateAll(world_, motion_, vehicle, 1));
  EXPECT_EQ(counts, (std::vector<std::size_t>{0, 0, 0, 0, 0, 401, 41}));
}

TEST_F(FlightSimulatorTest, oneSensorMoreDoesNotChangeTheOthers) {
  const auto all = messagesOf<LaserScan>(simulateAll(world_, motion_, smallVehicle(), 1));
  VehicleModel vehicle = smallVehicle();
  vehicle.imu.reset();
  vehicle.lidar.reset();
  vehicle.barometer.reset();
  const auto alone = messagesOf<LaserScan>(simulateAll(world_, motion_, vehicle, 1));
  ASSERT_EQ(all.size(), alone.size());
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].ranges, alone[i].ranges);
}

TEST_F(FlightSimulatorTest, aSecondLaserSweepsHalfwayBetweenTheSweepsOfTheFirst) {
  VehicleModel vehicle = smallVehicle();
  const auto alone = messagesOf<LaserScan>(simulateAll(world_, motion_, vehicle, 1));
  vehicle.second_laser = vehicle.laser;
  vehicle.base_T_second_laser.translate(Eigen::Vector3d(0.5, 0.0, 0.0));
  std::vector<LaserScan> first, second;
  for (const FlightEvent& event : simulateAll(world_, motion_, vehicle, 1)) {
    const auto* scan = std::get_if<LaserScan>(&event.message);
    if (scan != nullptr) (event.second_laser ? second : first).push_back(*scan);
  }
  ASSERT_EQ(first.size(), alone.size());
  ASSERT_EQ(second.size(), alone.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].ranges, alone[i].ranges);
    EXPECT_NEAR(second[i].stamp - first[i].stamp, 0.5 / vehicle.laser->rate_hz, 1e-6);
    EXPECT_NE(second[i].ranges, alone[i].ranges);
  }
}

TEST_F(FlightSimulatorTest, aBlockedViewCoversItsBeamsWhileItLasts) {
  VehicleModel vehicle = smallVehicle();
  const auto free = messagesOf<LaserScan>(simulateAll(world_, motion_, vehicle, 1));
  BlockedView view;
  view.from_s = 1.0;
  view.until_s = 2.0;
  view.first_rad = 0.0;
  view.range_m = 0.25;
  vehicle.blocked_views = {view};
  const auto blocked = messagesOf<LaserScan>(simulateAll(world_, motion_, vehicle, 1));
  ASSERT_EQ(blocked.size(), free.size());
  for (std::size_t i = 0; i < free.size(); ++i) {
    const bool during = i >= 10 && i < 20;  // at 10 Hz
    for (std::size_t k = 0; k < free[i].ranges.size(); ++k) {
      const double angle = free[i].angle_min + static_cast<double>(k) * free[i].angle_increment;
      if (std::abs(angle) < 1e-9) continue;
      if (during && angle > 0.0) {
        EXPECT_EQ(blocked[i].ranges[k], 0.25F);
      } else {
        EXPECT_TRUE(blocked[i].ranges[k] == free[i].ranges[k] || std::isnan(free[i].ranges[k]));
      }
    }
  }
}

TEST_F(FlightSimulatorTest, sameSeedSameMessagesOtherSeedOtherMessages) {
  const auto ranges = [&](std::uint64_t seed) {
    return messagesOf<LaserScan>(simulateAll(world_, motion_, smallVehicle(), seed))[3].ranges;
  };
  EXPECT_EQ(ranges(1), ranges(1));
  EXPECT_NE(ranges(1), ranges(2));
}

TEST_F(FlightSimulatorTest, refusesARateThatIsNone) {
  VehicleModel vehicle;
  vehicle.imu->rate_hz = 0.0;
  EXPECT_THROW(FlightSimulator(world_, motion_, vehicle, 1), std::invalid_argument);
}

TEST(VehicleModels, namesChooseTheScannerAndUnknownOnesAreAnsweredWithTheKnown) {
  const VehicleModel utm = quadrotorWith("utm30lx");
  EXPECT_EQ(utm.laser->beams, 1081);
  EXPECT_FALSE(utm.lidar.has_value());
  EXPECT_TRUE(utm.imu && utm.range_finder && utm.barometer);
  const VehicleModel vlp = quadrotorWith("vlp16");
  EXPECT_FALSE(vlp.laser.has_value());
  EXPECT_EQ(vlp.lidar->elevations.size(), 16U);
  try {
    quadrotorWith("sonar");
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    const std::string text = error.what();
    EXPECT_EQ(text.find("unknown sensor 'sonar'; there are utm30lx"), 0U) << text;
    EXPECT_NE(text.find("vlp16"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace kestrel_slam
