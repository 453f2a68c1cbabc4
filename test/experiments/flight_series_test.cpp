// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/flight_series.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/recording/simulated_recording.h"

namespace kestrel {
namespace {

/// A flight of `scans` scans along x, one meter each, mapped without an error.
FlightMeasurement straightFlight(std::size_t scans) {
  FlightMeasurement flight;
  for (std::size_t i = 0; i < scans; ++i) {
    const StampedPose pose = {static_cast<double>(i), Pose2(static_cast<double>(i), 0.0, 0.0)};
    flight.error.aligned.push_back(pose);
    flight.error.reference.push_back(pose);
    flight.run.scans.emplace_back();
    flight.run.scans.back().state = MatchState::kOk;
  }
  return flight;
}

void shiftFrom(FlightMeasurement& flight, std::size_t first, double meters) {
  Trajectory& poses = flight.error.aligned;
  for (std::size_t i = first; i < poses.size(); ++i) poses[i].pose.y += meters;
}

TEST(FlightSeries, CountsJumpsThatAreNotSaid) {
  FlightMeasurement flight = straightFlight(20);
  EXPECT_EQ(resultOf(flight).silent_jumps, 0U);
  shiftFrom(flight, 5, 0.02);  // below the limit
  shiftFrom(flight, 10, 0.08);
  shiftFrom(flight, 15, 0.05);
  EXPECT_EQ(resultOf(flight).silent_jumps, 2U);
  EXPECT_NEAR(resultOf(flight).largest_silent_jump_m, 0.08, 1e-9);
  flight.run.scans[10].state = MatchState::kDegraded;
  EXPECT_EQ(resultOf(flight).silent_jumps, 1U) << "said at the scan that jumps";
  flight.run.scans[14].state = MatchState::kLost;
  EXPECT_EQ(resultOf(flight).silent_jumps, 0U) << "said at the scan before";
}

TEST(FlightSeries, CountsScansThatAreWrongButOk) {
  FlightMeasurement flight = straightFlight(20);
  shiftFrom(flight, 12, 0.3);
  flight.run.scans[12].state = flight.run.scans[13].state = MatchState::kDegraded;
  EXPECT_EQ(resultOf(flight).wrong_and_ok, 6U);
  EXPECT_EQ(resultOf(flight).first_wrong, 14U);
  FlightMeasurement turned = straightFlight(20);
  turned.error.aligned.back().pose.yaw = degToRad(6.0);
  EXPECT_EQ(resultOf(turned).wrong_and_ok, 1U);
}

/// A pose that is wrong and called ok is the worst fault: with these flights it was wrong for the
/// rest of the flight after the floor had been followed, or a wrong loop was accepted.
TEST(FlightSeries, ATiltThatNoSensorMeasuresIsSaid) {
  constexpr std::size_t kWorst = 40;  // of 2300 scans
  for (const FlightTrial& standard : standardFlights()) {
    if (standard.name != "tilted flight, projector off") continue;
    for (const std::uint64_t seed : {2, 4}) {
      FlightTrial trial = standard;
      trial.seed = seed;
      const SeedResult result = resultOf(measureFlight(trial));
      EXPECT_LT(result.wrong_and_ok, kWorst) << "seed " << seed;
      EXPECT_EQ(result.loops.wrong, 0U) << "seed " << seed;
      EXPECT_LT(result.ate_m, 0.15) << "seed " << seed;
    }
  }
}

TEST(FlightSeries, FastTurnDrivesTurnAsFastAsTheySay) {
  double slowest = 1e9, fastest = 0.0, largest_step = 0.0;
  std::set<std::string> buildings;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const FlightTrial trial = fastTurnDrive(seed);
    EXPECT_EQ(trial.vehicle.laser->beams, 180);
    EXPECT_EQ(trial.vehicle.laser->rate_hz, 5.0);
    buildings.insert(trial.place.name);
    const SimulatedRecording recording(trial.place, trial.vehicle, trial.seed);
    double rate = 0.0;
    for (const TrueState& state : recording.trueStates())
      rate = std::max(rate, std::abs(state.angular_velocity.z()));
    slowest = std::min(slowest, radToDeg(rate));
    fastest = std::max(fastest, radToDeg(rate));
    const Trajectory& truth = recording.truth();
    for (std::size_t i = 1; i < truth.size(); ++i) {
      const double step = std::abs(truth[i - 1].pose.between(truth[i].pose).yaw);
      largest_step = std::max(largest_step, radToDeg(step));
    }
  }
  EXPECT_EQ(buildings.size(), 3U);
  EXPECT_GT(slowest, 40.0);
  EXPECT_LT(slowest, 150.0);
  EXPECT_GT(fastest, 200.0);
  EXPECT_LT(fastest, 310.0);
  EXPECT_GT(largest_step, 35.0);
  EXPECT_LT(largest_step, 65.0);
}

// In these drives the first guess was wrong by 20° to 45°, and the descent from it found a position
// that was wrong by 0.3 to 0.6 m, but fitted well.
TEST(FlightSeries, AFastTurnDoesNotEndAtAWrongPlaceThatFits) {
  for (const std::uint64_t seed : {7U, 10U, 19U, 25U, 29U, 34U, 46U, 183U}) {
    const SeedResult result = resultOf(measureFlight(fastTurnDrive(seed)));
    EXPECT_EQ(result.wrong_and_ok, 0U) << "seed " << seed << ", scan " << result.first_wrong;
    EXPECT_EQ(result.lost, 0U) << "seed " << seed;
  }
}

// The floor that the tilted laser saw was taken for the end of the corridor: 31 m and 270 standard
// deviations wrong.
TEST(FlightSeries, TheFloorIsNotTheEndOfACorridor) {
  for (const FlightSeries& series : flightSeries()) {
    if (series.name != "straight corridor") continue;
    FlightTrial trial = series.trial(3);
    trial.options.use_imu = false;
    const SeedResult result = resultOf(measureFlight(trial));
    EXPECT_LT(result.worst_long_m, 8.0);
    EXPECT_LT(result.worst_long_sigmas, 15.0);
    return;
  }
  FAIL() << "no such flight";
}

TEST(FlightSeries, EverySeedIsAnotherFlight) {
  for (const FlightSeries& series : flightSeries()) {
    EXPECT_EQ(series.trial(7).seed, 7U) << series.name;
    EXPECT_EQ(series.trial(7).name, series.name);
  }
}

}  // namespace
}  // namespace kestrel
