// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/simulation/flight_simulator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "simulation/statistics.h"
#include "simulation/test_flight.h"

namespace kestrel {
namespace {

std::vector<std::size_t> countsByType(const std::vector<FlightEvent>& events) {
  std::vector<std::size_t> counts(std::variant_size_v<FlightMessage>);
  for (const FlightEvent& event : events) ++counts[event.message.index()];
  return counts;
}

class FlightSimulatorTest : public testing::Test {
 protected:
  const World world_ = World(roomWithWalker());
  const KnownMotion motion_ = KnownMotion(4.0);
};

TEST_F(FlightSimulatorTest, EverySensorSendsAtItsRateDuringTheWholeFlight) {
  const auto counts = countsByType(simulateAll(world_, motion_, smallVehicle(), 1));
  const std::vector<std::size_t> expected = {39, 19, 401, 81, 41, 401, 41};
  EXPECT_EQ(counts, expected);  // laser, lidar, IMU, range finder, barometer, truth, walkers
}

TEST_F(FlightSimulatorTest, MessagesAreSortedByArrival) {
  const auto events = simulateAll(world_, motion_, smallVehicle(), 1);
  EXPECT_EQ(events.front().arrival, kFlightStart);
  for (std::size_t i = 1; i < events.size(); ++i) {
    ASSERT_LE(events[i - 1].arrival, events[i].arrival);
  }
}

TEST_F(FlightSimulatorTest, ArrivalIsTheEndOfTheSweepPlusTheLatency) {
  constexpr double kRounding = 1e-6;  // of stamps of 1.4e9 s
  for (const FlightEvent& event : simulateAll(world_, motion_, smallVehicle(), 1)) {
    const std::vector<double> expected = {0.0091 + 0.005, 0.2 + 0.005, 0.005, 0.01, 0.02, 0.0, 0.0};
    ASSERT_NEAR(event.arrival - event.stamp, expected[event.message.index()], kRounding)
        << event.message.index();
  }
}

TEST_F(FlightSimulatorTest, StampsOfMessagesEqualThoseOfTheEvents) {
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

TEST_F(FlightSimulatorTest, TruthIsTheMotionAtItsStamp) {
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

TEST_F(FlightSimulatorTest, JitterChangesStampsButNotMeasurements) {
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

TEST_F(FlightSimulatorTest, LossDoesNotChangeTheRemainingMessages) {
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

TEST_F(FlightSimulatorTest, AddingASensorDoesNotChangeTheOthers) {
  const auto all = messagesOf<LaserScan>(simulateAll(world_, motion_, smallVehicle(), 1));
  VehicleModel vehicle = smallVehicle();
  vehicle.imu.reset();
  vehicle.lidar.reset();
  vehicle.barometer.reset();
  const auto alone = messagesOf<LaserScan>(simulateAll(world_, motion_, vehicle, 1));
  ASSERT_EQ(all.size(), alone.size());
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].ranges, alone[i].ranges);
}

TEST_F(FlightSimulatorTest, SecondLaserIsShiftedByHalfAPeriod) {
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

TEST_F(FlightSimulatorTest, BlockedViewCoversItsBeamsDuringItsTime) {
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

TEST_F(FlightSimulatorTest, SeedDeterminesTheMessages) {
  const auto ranges = [&](std::uint64_t seed) {
    return messagesOf<LaserScan>(simulateAll(world_, motion_, smallVehicle(), seed))[3].ranges;
  };
  EXPECT_EQ(ranges(1), ranges(1));
  EXPECT_NE(ranges(1), ranges(2));
}

TEST_F(FlightSimulatorTest, RejectsARateOfZero) {
  VehicleModel vehicle;
  vehicle.imu->rate_hz = 0.0;
  EXPECT_THROW(FlightSimulator(world_, motion_, vehicle, 1), std::invalid_argument);
}

TEST(VehicleModels, NameSelectsTheScannerAndUnknownNamesListTheKnown) {
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
    EXPECT_EQ(text.find("unknown sensor 'sonar'; known: utm30lx"), 0U) << text;
    EXPECT_NE(text.find("vlp16"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace kestrel
