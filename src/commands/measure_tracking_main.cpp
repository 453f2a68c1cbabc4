// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/experiments/hard_flight.h"
#include "kestrel_slam/experiments/phd_scenario.h"
#include "kestrel_slam/experiments/walker_measurement.h"

namespace kestrel {
namespace {

struct Options {
  std::size_t runs = 100;
  std::uint64_t seed = 1;  ///< of the flight among people
};

/// Scans within which a new target must be found to count.
constexpr int kFoundWithin = 3;

std::size_t foundInTime(const PhdScenarioSummary& summary, std::size_t target) {
  return static_cast<std::size_t>(std::count_if(
      summary.single.begin(), summary.single.end(), [target](const PhdScenarioRun& run) {
        return run.found_after[target] >= 0 && run.found_after[target] <= kFoundWithin;
      }));
}

PhdScenarioSummary printRow(const char* name, const PhdScenario& scenario, std::size_t runs) {
  const PhdScenarioSummary s = summarizeScenario(scenario, runs);
  std::printf("| %s | %zu | %.2f | %.2f | %.2f | %.1f to %.1f | %.2f | %+.2f | %.1f |\n", name,
              s.runs, s.ospa, s.localization, s.cardinality, s.best, s.worst, s.sigma, s.count_bias,
              s.foundAfter());
  std::fflush(stdout);
  return s;
}

HardFlight flightCalled(const std::string& name) {
  for (const HardFlight& flight : hardFlights()) {
    if (flight.trial.name == name) return flight;
  }
  throw std::logic_error("there is no flight \"" + name + "\"");
}

void printWalkers(const HardFlight& flight) {
  constexpr double kPercent = 100.0;
  const WalkerMeasurement m = measureWalkers(flight);
  const ClearMot& people = m.tracks.moving;
  std::printf("| %s | %.1f %% | %.2f m | %zu | %zu | %zu | %.2f m/s | %zu, %zu | %.3f, %.3f m |\n",
              flight.trial.name.c_str(), kPercent * people.mota(), people.motp(), people.misses,
              people.false_tracks, people.switches, m.tracks.speed_rmse, m.with.ghost_cells,
              m.without.ghost_cells, m.with.ate_m, m.without.ate_m);
  const LossCounts& lost = m.tracks.losses;
  std::printf(
      "\npeople without a shown track: %zu without any, %zu not confirmed, %zu not known to move, "
      "%zu not seen for too long\n",
      lost.no_track, lost.tentative, lost.not_moving, lost.unseen);
}

void runWalkers(const Options& options) {
  std::puts(
      "\n| people around the vehicle | MOTA | MOTP | misses | false | switches | speed rmse | "
      "ghost "
      "cells with, without tracker | ATE with, without |\n|---|---|---|---|---|---|---|---|---|");
  HardFlight flight = flightCalled("twelve people");
  flight.trial.seed = options.seed;
  printWalkers(flight);
}

void runFilter(const Options& options) {
  std::puts(
      "| PHD filter | runs | OSPA, m | localization | cardinality | single runs | sigma | bias of "
      "the number | found after, scans |\n|---|---|---|---|---|---|---|---|---|");
  PhdScenario scenario = standardScenario();
  printRow("standard births, heavy components", scenario, options.runs);
  scenario.labeled = true;
  printRow("standard births, labeled targets", scenario, options.runs);
  scenario.adaptive_birth = true;
  printRow("adaptive births, labeled targets", scenario, options.runs);
  scenario = spawningScenario();
  const PhdScenarioSummary heavy = printRow("spawning, heavy components", scenario, options.runs);
  scenario.labeled = true;
  const PhdScenarioSummary labeled = printRow("spawning, labeled targets", scenario, options.runs);
  std::printf("\nspawned target found within %d scans: %zu and %zu of %zu runs\n", kFoundWithin,
              foundInTime(heavy, 2), foundInTime(labeled, 2), options.runs);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  Options options;
  bool no_people = false;
  CLI::App app("Measures the tracking of moving objects: prints the rows of doc/results.md.");
  app.add_option("--runs", options.runs, "Monte Carlo runs of each scenario of the PHD filter")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--seed", options.seed, "seed of the flight among people")->capture_default_str();
  app.add_flag("--no-people", no_people, "leave out the flight among people");
  return runTool("measure_tracking", app, argc, argv, [&] {
    runFilter(options);
    if (!no_people) runWalkers(options);
  });
}
