// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include "kestrel_slam/lidar/cloud_tracker.h"
#include "kestrel_slam/simulation/traffic.h"

namespace kestrel {
namespace {

/// A sweep of an HDL-64E that drives along the street: about 130 000 points.
void trackSweep(benchmark::State& state) {
  constexpr int kFrames = 20;
  const TrafficSimulator simulator(streetScene());
  std::vector<LidarSweep> sweeps;
  for (int frame = 0; frame < kFrames; ++frame) {
    LabeledSweep sweep = simulator.sweep(frame);
    sweeps.push_back({std::move(sweep.cloud), std::move(sweep.unanswered)});
  }
  for (auto _ : state) {
    CloudTracker tracker;
    for (const LidarSweep& sweep : sweeps) benchmark::DoNotOptimize(tracker.process(sweep).used);
  }
  state.counters["ms_per_sweep"] =
      benchmark::Counter(kFrames * static_cast<double>(state.iterations()) * 1e-3,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(trackSweep)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kestrel

BENCHMARK_MAIN();
