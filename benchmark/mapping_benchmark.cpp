// SPDX-License-Identifier: BSD-3-Clause
// Times of single operations in a simulated laboratory: 1081 beams, 5 cm cells.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <vector>

#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/recording/simulated_recording.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr std::size_t kMapScans = 100;

/// A map from the beginning of a flight, and the next scan, which is matched with the map.
struct Scene {
  Scene() : map(OccupancyGridConfig()) {
    Place laboratory = place("laboratory");
    laboratory.quadrotor.level = true;  // the attitude is not part of this benchmark
    VehicleModel vehicle = quadrotorWith("utm30lx");
    vehicle.laser->time_increment = 0.0;  // all beams at the same time, without motion
    ScanProjector projector{ProjectorConfig()};
    SimulatedRecording flight(laboratory, vehicle, kSeed);
    RecordedScan recorded;
    for (std::size_t i = 0; i <= kMapScans && flight.next(recorded); ++i) {
      scan = projector.project(recorded.scan, recorded.base_T_laser).scan;
      pose = flight.truth()[i].pose;
      if (i < kMapScans) map.insert(scan, pose);
    }
    points = hitsOf(scan);
  }

  Submap map;
  PlanarScan scan;
  Pose2 pose;
  Points points;
};

const Scene& scene() {
  static const Scene instance;
  return instance;
}

void match(benchmark::State& state, const char* method, const Pose2& offset) {
  MatcherConfig config;
  config.method = method;
  const std::unique_ptr<Matcher> matcher = makeMatcher(config);
  const Pose2 initial_guess = scene().pose * offset;
  const MatchRequest request{scene().points, initial_guess, {initial_guess}, false, 1.0};
  for (auto _ : state) benchmark::DoNotOptimize(matcher->match(scene().map, request));
}

/// A map of about 100 000 m²: rooms in a square, 250 m wide.
Submap hugeMap() {
  Submap map{OccupancyGridConfig()};
  constexpr int kRooms = 32;
  constexpr double kSpacing = 10.0;  // m
  for (int row = 0; row < kRooms; ++row) {
    for (int column = 0; column < kRooms; ++column) {
      map.insert(scene().scan, Pose2(kSpacing * column, kSpacing * row, 0.0));
    }
  }
  return map;
}

/// The longest time in which a publisher keeps the matching waiting: a copy of 32 changed tiles.
void copyChangedTiles(benchmark::State& state) {
  Submap map = hugeMap();
  const MapSnapshot whole = map.grid().snapshot();
  double longest_ms = 0.0;
  std::vector<TileImage> images;
  for (auto _ : state) {
    state.PauseTiming();
    for (int i = 0; i < 10; ++i) map.insert(scene().scan, Pose2(10.0 * i, 10.0 * i, 0.0));
    state.ResumeTiming();
    for (bool more = true; more;) {
      images.clear();
      const auto start = std::chrono::steady_clock::now();
      more = map.grid().takeChangedTiles(32, images);
      const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
      longest_ms = std::max(longest_ms, ms.count());
    }
  }
  state.counters["map_m2"] = whole.width * whole.height * whole.resolution_m * whole.resolution_m;
  state.counters["longest_wait_ms"] = longest_ms;
}

void search(benchmark::State& state, const SearchWindow& window) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(searchWindow(scene().map.surface(), scene().points, scene().pose,
                                          window, CorrelativeConfig()));
  }
}

void insert(benchmark::State& state) {
  for (auto _ : state) {
    state.PauseTiming();
    Submap map = Submap(OccupancyGridConfig());
    map.insert(scene().scan, scene().pose);
    state.ResumeTiming();
    benchmark::DoNotOptimize(map.insert(scene().scan, scene().pose * Pose2(0.2, 0.0, 0.05)));
  }
}

void snapshot(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(scene().map.grid().snapshot());
}

BENCHMARK(copyChangedTiles)->Unit(benchmark::kMicrosecond)->Iterations(20);
BENCHMARK_CAPTURE(match, hybrid, "hybrid", Pose2(0.05, 0.02, 0.03));
BENCHMARK_CAPTURE(match, gauss_newton, "gauss_newton", Pose2(0.05, 0.02, 0.03));
BENCHMARK_CAPTURE(match, correlative, "correlative", Pose2(0.05, 0.02, 0.03));
BENCHMARK_CAPTURE(match, progressive, "progressive", Pose2(0.05, 0.02, 0.03));
BENCHMARK_CAPTURE(match, icp, "icp", Pose2(0.05, 0.02, 0.03));
BENCHMARK_CAPTURE(search, half_meter_20_deg, SearchWindow{0.5, 0.35});
BENCHMARK_CAPTURE(search, one_meter_180_deg, SearchWindow{1.0, 3.14});
BENCHMARK(insert);
BENCHMARK(snapshot);

}  // namespace
}  // namespace kestrel

BENCHMARK_MAIN();
