// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/graph_worker.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "kestrel_slam/experiments/flight_measurement.h"

namespace kestrel {
namespace {

struct Flight {
  MapperConfig mapper;
  LoopConfig loops;
  std::vector<std::pair<PlanarScan, MapperResult>> scans;
};

/// A flight that comes back to its start.
Flight flightWithLoops() {
  Flight flight;
  FlightTrial trial = flightIn("flight with loops", "ring");
  trial.options.observer = [&](const PlanarScan& scan, const MapperResult& result) {
    flight.scans.emplace_back(scan, result);
  };
  flight.mapper = trial.config.mapper;
  flight.loops = trial.config.loops;
  measureFlight(trial);
  return flight;
}

/// The corrections of all scans. The thread may be late by up to `late` scans.
std::vector<Pose2> correctionsOf(const Flight& flight, std::size_t late) {
  GraphWorker worker(flight.mapper, flight.loops);
  std::vector<Pose2> result;
  for (const auto& [scan, found] : flight.scans) {
    worker.add(scan, found);
    result.push_back(worker.correction().map_T_local);
    if (result.size() % late == 0) worker.snapshot();  // waits for the thread
  }
  return result;
}

TEST(GraphWorker, TheCorrectionsDoNotDependOnTheSpeedOfTheThread) {
  const Flight flight = flightWithLoops();
  const std::vector<Pose2> at_once = correctionsOf(flight, 1);
  const std::vector<Pose2> late = correctionsOf(flight, GraphWorker::kCorrectionDelay - 1);
  ASSERT_EQ(at_once.size(), late.size());
  for (std::size_t i = 0; i < late.size(); ++i) ASSERT_EQ(at_once[i], late[i]) << i;
  EXPECT_FALSE(late.back() == Pose2());
}

}  // namespace
}  // namespace kestrel
