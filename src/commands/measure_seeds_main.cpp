// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/experiments/flight_series.h"
#include "kestrel_slam/map/atomic_file.h"

namespace kestrel {
namespace {

constexpr double kMillimeters = 1e3, kPercent = 100.0;

struct Options {
  int seeds = 10, first_seed = 1;
  std::string only, imu = "use", json;
  std::vector<std::string> settings;  ///< name=value
  bool list = false;
};

nlohmann::ordered_json jsonOf(const SeedResult& r) {
  return {{"seed", r.seed},
          {"scans", r.scans},
          {"lost", r.lost},
          {"degraded", r.degraded},
          {"ate_m", r.ate_m},
          {"worst_m", r.worst_m},
          {"silent_jumps", r.silent_jumps},
          {"largest_silent_jump_m", r.largest_silent_jump_m},
          {"wrong_and_ok", r.wrong_and_ok},
          {"first_wrong", r.first_wrong},
          {"worst_long_m", r.worst_long_m},
          {"worst_long_sigmas", r.worst_long_sigmas},
          {"worst_short_m", r.worst_short_m},
          {"first_quarter_ms", r.first_quarter_ms},
          {"last_quarter_ms", r.last_quarter_ms},
          {"area_m2", r.area_m2},
          {"loops",
           {{"accepted", r.loops.accepted},
            {"wrong", r.loops.wrong},
            {"worst_m", r.loops.worst_m},
            {"revisits", r.loops.revisits},
            {"found", r.loops.found},
            {"nees", r.loops.nees}}}};
}

void printRow(const std::string& name, const std::vector<SeedResult>& results) {
  std::vector<double> errors, nees;
  SeedResult sum;
  for (const SeedResult& r : results) {
    errors.push_back(r.ate_m);
    sum.scans += r.scans;
    sum.lost += r.lost;
    sum.degraded += r.degraded;
    sum.silent_jumps += r.silent_jumps;
    sum.wrong_and_ok += r.wrong_and_ok;
    sum.loops.accepted += r.loops.accepted;
    sum.loops.wrong += r.loops.wrong;
    sum.loops.revisits += r.loops.revisits;
    sum.loops.found += r.loops.found;
    nees.insert(nees.end(), r.loops.nees.begin(), r.loops.nees.end());
    sum.largest_silent_jump_m = std::max(sum.largest_silent_jump_m, r.largest_silent_jump_m);
  }
  const ErrorStatistics ate = statisticsOf(errors);
  const double percent = kPercent / static_cast<double>(std::max<std::size_t>(sum.scans, 1));
  std::printf(
      "| %s | %zu | %.1f mm | %.1f mm | %zu, %.0f mm | %.2f %% | %.2f %% | %zu | "
      "%zu of %zu | %zu of %zu | %.2f |\n",
      name.c_str(), results.size(), kMillimeters * ate.median, kMillimeters * ate.max,
      sum.silent_jumps, kMillimeters * sum.largest_silent_jump_m,
      percent * static_cast<double>(sum.lost), percent * static_cast<double>(sum.degraded),
      sum.wrong_and_ok, sum.loops.wrong, sum.loops.accepted, sum.loops.found, sum.loops.revisits,
      statisticsOf(nees).median);
  std::fflush(stdout);
}

std::vector<SeedResult> measure(const FlightSeries& series, const Options& options) {
  std::vector<SeedResult> results;
  for (int seed = options.first_seed; seed < options.first_seed + options.seeds; ++seed) {
    FlightTrial trial = series.trial(static_cast<std::uint64_t>(seed));
    applySettings(options.settings, trial.config);
    if (options.imu == "none") trial.options.use_imu = false;
    std::fprintf(stderr, "%s, seed %d in %s\n", series.name.c_str(), seed,
                 trial.place.name.c_str());
    results.push_back(resultOf(measureFlight(trial)));
    results.back().seed = trial.seed;
  }
  return results;
}

/// The flight called `only`, or else all flights whose name contains it.
std::vector<FlightSeries> chosen(const std::string& only) {
  std::vector<FlightSeries> result;
  for (const FlightSeries& series : flightSeries()) {
    if (series.name == only) return {series};
    if (series.name.find(only) != std::string::npos) result.push_back(series);
  }
  return result;
}

void run(const Options& options) {
  const std::vector<FlightSeries> all = chosen(options.only);
  if (options.list) {
    for (const FlightSeries& series : all) std::puts(series.name.c_str());
    return;
  }
  std::printf(
      "| flight | seeds | ATE rmse, median | worst | silent jumps above 30 mm, largest | lost | "
      "degraded | wrong and ok | wrong loops | revisits with a loop | NEES with loops, median |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const FlightSeries& series : all) {
    const std::vector<SeedResult> results = measure(series, options);
    printRow(series.name, results);
    for (const SeedResult& result : results) json[series.name].push_back(jsonOf(result));
  }
  if (!options.json.empty()) writeFileAtomically(options.json, json.dump(2) + "\n");
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  Options options;
  CLI::App app(
      "Maps simulated flights and drives with several seeds each and prints the median and the "
      "worst error, and whether errors were said.");
  app.add_option("--only", options.only,
                 "run only the flight with this name, or else those whose name contains it");
  app.add_option("--seeds", options.seeds, "number of seeds of each flight")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--seed", options.first_seed, "the first seed")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--imu", options.imu, "use (default), or none: the vehicle is assumed to be level")
      ->check(CLI::IsMember({"none", "use"}));
  app.add_option("--set", options.settings, "name=value: sets a parameter, see map_recording");
  app.add_option("--json", options.json, "write the figures of every seed to this file");
  app.add_flag("--list", options.list, "print the names of the flights and exit");
  return runTool("measure_seeds", app, argc, argv, [&] { run(options); });
}
