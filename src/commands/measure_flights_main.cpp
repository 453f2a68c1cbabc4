// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/experiments/drive_measurement.h"
#include "kestrel_slam/experiments/flight_measurement.h"
#include "kestrel_slam/experiments/hard_flight.h"
#include "kestrel_slam/map/map_io.h"

namespace kestrel {
namespace {

constexpr double kMillimeter = 1e-3, kPercent = 100.0;

struct Options {
  int random_flights = 100;
  int first_seed = 1;  ///< seed of the first random flight
  double random_s = 30.0;
  std::string only;
  std::vector<std::string> settings;  ///< name=value
  std::string output;                 ///< folder; empty: only the table
};

void printHeader() {
  std::printf(
      "| flight | scans | lost | ATE rmse | ATE max | yaw rmse | yaw max | tilt max | "
      "false cells | NEES pose, in band | NEES 1 s, in band | max error, long axis | max error, "
      "short axis |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
}

void printRow(const std::string& name, const FlightMeasurement& m) {
  const ErrorStatistics& position = m.error.ate_statistics.translation_m;
  const ErrorStatistics& yaw = m.error.ate_statistics.rotation_deg;
  const Consistency& c = m.consistency;
  std::printf("| %s | %zu | %zu | %.4f m | %.3f m | %.3f° | %.2f° | %.1f° | %zu of %zu ",
              name.c_str(), m.run.scans.size(), m.lost, position.rmse, position.max, yaw.rmse,
              yaw.max, m.max_tilt_deg, m.false_cells, m.occupied_cells);
  std::printf("| %.1f, %.0f %% | %.1f, %.0f %% | %.3f m, %.1f sigma | %.3f m |\n",
              meanOf(c.absolute), kPercent * shareWithin(c.absolute, kNeesBand), meanOf(c.relative),
              kPercent * shareWithin(c.relative, kNeesBand), c.worst_long_m, c.worst_long_sigmas,
              c.worst_short_m);
  for (const std::string& warning : m.run.warnings) {
    std::fprintf(stderr, "  %s: %s\n", name.c_str(), warning.c_str());
  }
  std::fflush(stdout);
}

/// Writes map, estimated and true trajectory of a flight. File names are the flight's name with
/// hyphens.
void writeFiles(const std::string& folder, const std::string& name, const FlightMeasurement& m) {
  std::string path = name;
  std::replace_if(
      path.begin(), path.end(), [](char c) { return c == ' ' || c == ',' || c == '/'; }, '-');
  path = (std::filesystem::path(folder) / path).string();
  std::filesystem::create_directories(folder);
  writeMap(path, m.run.map);
  writeTum(path + ".tum", m.error.aligned);
  writeTum(path + "_truth.tum", m.error.reference);
}

/// Prints how well the covariances fit the errors. Flights are independent, but the seconds of one
/// flight are correlated. So the mean over all flights is computed for each second and compared
/// with the band for that number of independent values.
void printConsistency(const char* what, const std::vector<std::vector<double>>& flights) {
  std::vector<double> all, means;
  std::size_t seconds = 0;
  for (const std::vector<double>& flight : flights) seconds = std::max(seconds, flight.size());
  for (std::size_t t = 0; t < seconds; ++t) {
    std::vector<double> now;
    for (const std::vector<double>& flight : flights) {
      if (t < flight.size()) now.push_back(flight[t]);
    }
    all.insert(all.end(), now.begin(), now.end());
    if (now.size() == flights.size()) means.push_back(meanOf(now));
  }
  if (all.empty()) return;
  const auto band = meanNeesBand(flights.size());
  std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2),
                   all.end());
  const double median = all[all.size() / 2];
  std::printf(
      "NEES of the %s: mean %.2f (expected 3), median %.2f (expected 2.37); %.0f %% of the values "
      "are "
      "within the 95 %% band of %.2f to %.2f, %.0f %% below its upper limit; the mean over the "
      "flights is within its 95 %% band of %.2f to %.2f in %.0f %% of the seconds\n",
      what, meanOf(all), median, kPercent * shareWithin(all, kNeesBand), kNeesBand.first,
      kNeesBand.second, kPercent * shareWithin(all, {0.0, kNeesBand.second}), band.first,
      band.second, kPercent * shareWithin(means, band));
}

/// Random flights in all indoor places except hall and corridor, in which the laser does not
/// constrain every direction.
void flyAtRandom(const Options& options) {
  std::vector<std::string> names;
  for (const Place& candidate : places()) {
    if (candidate.name == "hall" || candidate.name == "corridor") continue;
    if (candidate.name.find("town") == std::string::npos) names.push_back(candidate.name);
  }
  std::size_t lost_flights = 0, scans = 0;
  double worst = 0.0;
  std::vector<std::vector<double>> absolute, relative;  // for each flight
  for (int i = 0; i < options.random_flights; ++i) {
    const auto number = static_cast<std::size_t>(i);
    FlightTrial trial = flightIn("random", names[number % names.size()]);
    trial.seed = number + static_cast<std::size_t>(options.first_seed);
    applySettings(options.settings, trial.config);
    trial.place.plan = randomPlan(trial.place, options.random_s, trial.seed);
    const FlightMeasurement m = measureFlight(trial);
    const double error = m.error.ate_statistics.translation_m.max;
    constexpr double kLostError =
        0.5;  // m; larger errors count as lost, even if the mapper does not report it
    if (m.lost > 0 || error > kLostError) {
      ++lost_flights;
      printRow("random flight " + std::to_string(i) + " in " + trial.place.name, m);
    }
    worst = std::max(worst, error);
    scans += m.run.scans.size();
    absolute.push_back(m.consistency.absolute);
    relative.push_back(m.consistency.relative);
  }
  std::printf(
      "\n%d random flights of %.0f s, %zu scans: %zu lost; largest position error %.0f mm\n",
      options.random_flights, options.random_s, scans, lost_flights, worst / kMillimeter);
  printConsistency("pose", absolute);
  printConsistency("motion over 1 s", relative);
}

void flyInHardSituations(const Options& options) {
  std::printf(
      "\n| hard situation | scans | lost | false alarms | missed | ATE rmse | largest jump | "
      "recovery time | ghost cells | double walls | limits |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (HardFlight hard : hardFlights()) {
    if (hard.trial.name.find(options.only) == std::string::npos) continue;
    applySettings(options.settings, hard.trial.config);
    const HardFlightMeasurement m = measureHardFlight(hard);
    const std::string failures = m.failures(hard.limits);
    std::printf("| %s | %zu | %zu | %zu | %zu | %.4f m | %.3f m | %.2f s | %zu | %zu | %s |\n",
                hard.trial.name.c_str(), m.flight.run.scans.size(), m.lost, m.false_alarms,
                m.missed, m.ate_m, m.jump_m, m.recovery_s, m.ghost_cells, m.double_cells,
                failures.empty() ? "kept" : failures.c_str());
    std::fflush(stdout);
    if (!options.output.empty()) writeFiles(options.output, hard.trial.name, m.flight);
  }
}

void drive(FlightTrial trial, const Options& options) {
  if (trial.name.find(options.only) == std::string::npos) return;
  applySettings(options.settings, trial.config);
  const DriveMeasurement m = measureDrive(trial);
  const FlightMeasurement& flight = m.flight;
  std::printf(
      "\n%s with two lasers of 200 m range, %.0f cm cells: %zu scans, %zu lost, ATE %.3f m, final "
      "error %.3f m and %.2f°; %.0f m² mapped\n",
      trial.name.c_str(), 100.0 * trial.config.mapper.grid.resolution_m, flight.run.scans.size(),
      flight.lost, flight.error.ate_statistics.translation_m.rmse, m.end_error_m, m.end_error_deg,
      m.area_m2);
  std::printf("| quarter of the drive | ms per scan (median) | map |\n|---|---|---|\n");
  for (std::size_t i = 0; i < m.quarters.size(); ++i) {
    std::printf("| %zu | %.2f | %.0f MB |\n", i + 1, m.quarters[i].median_ms, m.quarters[i].map_mb);
  }
  if (!options.output.empty()) writeFiles(options.output, trial.name, flight);
}

void run(const Options& options) {
  printHeader();
  for (FlightTrial trial : standardFlights()) {
    if (trial.name.find(options.only) == std::string::npos) continue;
    applySettings(options.settings, trial.config);
    const FlightMeasurement m = measureFlight(trial);
    printRow(trial.name, m);
    if (!options.output.empty()) writeFiles(options.output, trial.name, m);
  }
  flyInHardSituations(options);
  drive(townDrive(), options);
  drive(largeTownDrive(), options);
  if (options.random_flights > 0) flyAtRandom(options);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  Options options;
  CLI::App app("Maps simulated flights and prints the errors with respect to the true poses.");
  app.add_option("--random", options.random_flights, "number of random flights")
      ->capture_default_str();
  app.add_option("--seed", options.first_seed, "seed of the first random flight")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--random-duration", options.random_s, "duration of each random flight, s")
      ->capture_default_str();
  app.add_option("--only", options.only, "run only flights whose name contains this text");
  app.add_option("--set", options.settings, "name=value: sets a parameter, see map_recording");
  app.add_option("--output", options.output, "output folder for maps and trajectories");
  return runTool("measure_flights", app, argc, argv, [&] { run(options); });
}
