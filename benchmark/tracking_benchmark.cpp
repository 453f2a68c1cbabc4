// SPDX-License-Identifier: BSD-3-Clause
// The tracker of a planar laser: 1081 beams, 40 Hz, ten people who walk around the vehicle.

#include <benchmark/benchmark.h>

#include <utility>
#include <vector>

#include "kestrel_slam/experiments/hard_flight.h"
#include "kestrel_slam/recording/simulated_recording.h"
#include "kestrel_slam/sensor/scan_projector.h"
#include "kestrel_slam/tracking/tracker.h"

namespace kestrel {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr std::size_t kScans = 400;
constexpr std::size_t kPeople = 10;

struct PosedScan {
  PlanarScan scan;
  Pose2 pose;
};

/// The flight among people with true poses: the mapper is not part of this benchmark.
std::vector<PosedScan> flightAmongPeople() {
  std::vector<PosedScan> result;
  for (const HardFlight& flight : hardFlights()) {
    if (flight.trial.name != "twelve people") continue;
    Place place = flight.trial.place;
    place.parts.walkers.resize(kPeople);
    SimulatedRecording recording(place, flight.trial.vehicle, kSeed);
    ScanProjector projector{ProjectorConfig()};
    RecordedScan recorded;
    while (result.size() < kScans && recording.next(recorded)) {
      PlanarScan scan = projector.project(recorded.scan, recorded.base_T_laser).scan;
      scan.time = scan.stamp;
      result.push_back({std::move(scan), recording.truth()[result.size()].pose});
    }
  }
  return result;
}

/// Once, so that the instructions can be counted: see scripts/benchmark.
void trackPeople(benchmark::State& state) {
  const std::vector<PosedScan> flight = flightAmongPeople();
  for (auto _ : state) {
    Tracker tracker;
    for (const PosedScan& posed : flight) {
      benchmark::DoNotOptimize(tracker.process(posed.scan, posed.pose).used);
    }
  }
  state.counters["scans"] = static_cast<double>(flight.size());
}
BENCHMARK(trackPeople)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace kestrel

BENCHMARK_MAIN();
