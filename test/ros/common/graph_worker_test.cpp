// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/graph_worker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "kestrel_slam/experiments/flight_measurement.h"
#include "kestrel_slam/map/map_replica.h"

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

std::size_t knownCells(const MapSnapshot& map) {
  return static_cast<std::size_t>(std::count_if(
      map.cells.begin(), map.cells.end(), [](auto cell) { return cell != MapSnapshot::kUnknown; }));
}

/// The map is composed when the queue is empty, and before a snapshot.
TEST(GraphWorker, ASnapshotWaitsForTheMap) {
  const Flight flight = flightWithLoops();
  GraphWorker worker(flight.mapper, flight.loops);
  for (const auto& [scan, found] : flight.scans) worker.add(scan, found);
  const GraphRecord record = worker.snapshot().record;
  MapReplica replica(flight.mapper.grid.resolution_m);
  std::vector<TileImage> tiles;
  std::uint64_t number = 0;
  while (worker.takeChangedTiles(32, tiles, number)) continue;
  for (const TileImage& tile : tiles) replica.update(tile);
  ComposedMap all(flight.mapper.grid);
  all.add(SubmapGraph(flight.mapper, flight.loops, record));
  const double expected = static_cast<double>(knownCells(all.grid().snapshot()));
  EXPECT_GT(expected, 1000.0);
  EXPECT_NEAR(static_cast<double>(knownCells(replica.snapshot())), expected, 0.01 * expected);
}

}  // namespace
}  // namespace kestrel
