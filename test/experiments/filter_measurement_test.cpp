// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/filter_measurement.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "kestrel_slam/evaluation/consistency.h"
#include "kestrel_slam/simulation/flight_plan.h"

namespace kestrel {
namespace {

FilterTrial trialIn(const std::string& place) {
  FilterTrial trial;
  trial.flight = flightIn("test", place);
  return trial;
}

FilterTrial randomTrial(const std::string& place, std::uint64_t seed) {
  constexpr double kDuration_s = 15.0;
  FilterTrial trial = trialIn(place);
  trial.flight.seed = seed;
  trial.flight.place.plan = randomPlan(trial.flight.place, kDuration_s, seed);
  return trial;
}

void expectGoodState(const FilterMeasurement& m) {
  EXPECT_LT(m.xy_rmse_m, 0.02);
  EXPECT_LT(m.z_rmse_m, 0.03);
  EXPECT_LT(m.velocity_rmse, 0.03);
  EXPECT_LT(m.tilt_rmse_deg, 0.3);
  EXPECT_LT(m.worst_step, 2.0);
}

TEST(FilterMeasurement, LaboratoryLoop) {
  const FilterMeasurement m = measureFilter(trialIn("laboratory"));
  expectGoodState(m);
  EXPECT_EQ(m.lost, 0U);
  EXPECT_EQ(m.status.reinitializations, 0U);
  EXPECT_TRUE(m.status.resets.empty());
}

TEST(FilterMeasurement, TwoSecondsWithoutAScan) {
  FilterTrial trial = trialIn("laboratory");
  trial.blind_from_s = 20.0;
  trial.blind_until_s = 22.0;
  const FilterMeasurement m = measureFilter(trial);
  EXPECT_GT(m.return_error_m, 0.0);
  EXPECT_LT(m.return_error_m, 0.3);
  EXPECT_EQ(m.lost, 0U);
  expectGoodState(m);  // no second map
}

TEST(FilterMeasurement, ThePredictionSavesIterations) {
  FilterTrial trial = trialIn("laboratory");
  trial.flight.vehicle.laser->errors.dropout_probability = 0.4;
  const FilterMeasurement with = measureFilter(trial);
  trial.coupling.attitude = trial.coupling.height = trial.coupling.prediction = false;
  const FilterMeasurement without = measureFilter(trial);
  EXPECT_LT(with.iterations, 0.9 * without.iterations);
  EXPECT_LT(with.mapper_rmse_m, 0.01);
  expectGoodState(with);
  expectGoodState(without);
}

/// Nothing but the beams that meet the floor says how high the vehicle is.
TEST(FilterMeasurement, FloorBeamsGiveTheHeight) {
  FilterTrial trial = trialIn("laboratory");
  for (const FlightTrial& flight : standardFlights()) {
    if (flight.name == "tilt up to 20 deg") trial.flight = flight;
  }
  trial.flight.vehicle.range_finder.reset();
  const FilterMeasurement m = measureFilter(trial);
  const SensorCounts& beams = m.status.of(FilterSensor::kFloorBeams);
  EXPECT_GT(beams.accepted, 20U);
  EXPECT_GT(beams.accepted, 9 * (beams.received - beams.accepted));
  EXPECT_EQ(m.status.of(FilterSensor::kRange).received, 0U);
  EXPECT_LT(m.xy_rmse_m, 0.03);
  EXPECT_LT(m.z_end_m, 0.05);
}

TEST(FilterMeasurement, WhatItClaimsIsWhatItIsWrongBy) {
  std::vector<double> nees;
  std::uint64_t seed = 1;
  for (const char* place : {"laboratory", "ring", "glass", "doors"}) {
    for (int i = 0; i < 3; ++i) {
      const FilterMeasurement m = measureFilter(randomTrial(place, seed++));
      nees.insert(nees.end(), m.nees.begin(), m.nees.end());
    }
  }
  EXPECT_GT(meanOf(nees), 9.0);  // 15 is right
  EXPECT_LT(meanOf(nees), 20.0);
}

}  // namespace
}  // namespace kestrel
