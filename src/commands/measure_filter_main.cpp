// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "kestrel_slam/commands/mapping_command.h"
#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/evaluation/consistency.h"
#include "kestrel_slam/experiments/filter_measurement.h"
#include "kestrel_slam/experiments/recorded_filter.h"
#include "kestrel_slam/offline/stats.h"
#include "kestrel_slam/parameters/filter_parameters.h"
#include "kestrel_slam/parameters/parameters_yaml.h"
#include "kestrel_slam/recording/reference.h"
#include "kestrel_slam/simulation/flight_plan.h"

namespace kestrel {
namespace {

constexpr double kPercent = 100.0;

struct Options {
  int hard_flights = 8;  ///< flights of each kind
  int random_flights = 50;
  int first_seed = 1;
  double random_s = 30.0;
  double cost_s = 100.0;
  std::string only;
  bool counts = false;
  std::vector<std::string> bags;
  std::string reference_topic;
  std::vector<std::string> settings;  ///< name=value, for projector and mapper
  std::vector<std::string> filter_settings;
  PoseFilterConfig filter;  ///< configuration with `filter_settings`
  bool list_parameters = false;
  std::vector<double> laser_pose;  ///< see laserPoseOf
};

bool isWanted(const Options& options, const std::string& name) {
  return name.find(options.only) != std::string::npos;
}

FilterMeasurement measure(FilterTrial trial, const Options& options) {
  trial.filter = options.filter;
  return measureFilter(trial);
}

FilterTrial trialIn(const std::string& name, const std::string& place) {
  FilterTrial trial;
  trial.flight = flightIn(name, place);
  return trial;
}

FilterTrial gusts() {
  FilterTrial trial = trialIn("gusts of 1.5 m/s²", "laboratory");
  trial.flight.place.quadrotor.gust_m_s2 = 1.5;
  return trial;
}

FilterTrial standard(const std::string& name) {
  FilterTrial trial;
  for (const FlightTrial& flight : standardFlights()) {
    if (flight.name == name) trial.flight = flight;
  }
  return trial;
}

FilterTrial dropouts() {
  FilterTrial trial = trialIn("40 % of the beams drop out", "laboratory");
  trial.flight.vehicle.laser->errors.dropout_probability = 0.4;
  return trial;
}

FilterTrial scansMissing() {
  FilterTrial trial = trialIn("no scan for 2 s", "laboratory");
  trial.blind_from_s = 20.0;
  trial.blind_until_s = 22.0;
  return trial;
}

FilterTrial allDisturbances() {
  FilterTrial trial = standard("spin at 2 rad/s");
  trial.flight.name = "gusts, 2 rad/s and dropouts";
  trial.flight.place.quadrotor.gust_m_s2 = 1.5;
  trial.flight.vehicle.laser->errors.dropout_probability = 0.4;
  return trial;
}

void printCounts(const FilterStatus& status) {
  for (std::size_t i = 0; i < kFilterSensors; ++i) {
    const SensorCounts& counts = status.sensors[i];
    if (counts.received == 0) continue;
    std::printf("    %s: %zu received, %zu accepted", toString(static_cast<FilterSensor>(i)),
                counts.received, counts.accepted);
    for (const auto& [reason, n] : counts.rejected) std::printf(", %s %zu", reason.c_str(), n);
    std::printf("\n");
  }
  std::printf("    reinitializations %zu", status.reinitializations);
  for (const auto& [reason, n] : status.resets) std::printf(", reset (%s) %zu", reason.c_str(), n);
  std::printf("\n");
}

void printFilterHeader() {
  std::printf(
      "| flight | xy rmse, max | z rmse | velocity rmse | roll, pitch rmse | yaw rmse | odom: "
      "largest step and its ratio to the true motion | NEES (15 states) | error after scans were "
      "missing |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
}

void printFilterRow(const FilterTrial& trial, const FilterMeasurement& m, const Options& options) {
  std::printf(
      "| %s | %.4f m, %.3f m | %.4f m | %.4f m/s | %.3f° | %.3f° | %.4f m, %.2f | %.1f | %.3f m "
      "|\n",
      trial.flight.name.c_str(), m.xy_rmse_m, m.xy_max_m, m.z_rmse_m, m.velocity_rmse,
      m.tilt_rmse_deg, m.yaw_rmse_deg, m.largest_step_m, m.worst_step, meanOf(m.nees),
      m.return_error_m);
  if (options.counts) printCounts(m.status);
  std::fflush(stdout);
}

void flyWithTruth(const Options& options) {
  printFilterHeader();
  for (const FilterTrial& trial : {trialIn("laboratory loop", "laboratory"), scansMissing(),
                                   gusts(), standard("spin at 2 rad/s"),
                                   standard("tilt up to 20 deg"), standard("straight corridor")}) {
    if (!isWanted(options, trial.flight.name)) continue;
    printFilterRow(trial, measure(trial, options), options);
  }
}

/// Repeats a flight with several seeds, because a single flight is not representative.
void printMapperRow(FilterTrial trial, const char* how, const Options& options) {
  std::vector<double> lost, searched, fallbacks, iterations, mapper, filter;
  for (int i = 0; i < options.hard_flights; ++i) {
    trial.flight.seed = static_cast<std::uint64_t>(options.first_seed + i);
    const FilterMeasurement m = measure(trial, options);
    lost.push_back(static_cast<double>(m.lost));
    searched.push_back(static_cast<double>(m.searched));
    fallbacks.push_back(static_cast<double>(m.fallbacks));
    iterations.push_back(m.iterations);
    mapper.push_back(m.mapper_rmse_m);
    filter.push_back(m.xy_rmse_m);
  }
  const Distribution of_mapper = distributionOf(mapper), of_filter = distributionOf(filter);
  std::printf("| %s | %s | %.1f | %.1f | %.0f | %.2f | %.4f m, %.3f m | %.4f m, %.3f m |\n",
              trial.flight.name.c_str(), how, meanOf(lost), meanOf(searched), meanOf(fallbacks),
              meanOf(iterations), of_mapper.median, of_mapper.max, of_filter.median, of_filter.max);
  std::fflush(stdout);
}

/// Compares the mapper with and without data from the filter.
void compareCoupling(const Options& options) {
  std::printf(
      "\nMeans of %d flights each; errors: median and maximum.\n"
      "| hard flight | filter gives | lost | searched | fallbacks | iterations | mapper rmse | "
      "filter rmse |\n|---|---|---|---|---|---|---|---|\n",
      options.hard_flights);
  for (FilterTrial trial :
       {gusts(), standard("spin at 2 rad/s"), dropouts(), allDisturbances(), scansMissing()}) {
    if (!isWanted(options, trial.flight.name)) continue;
    trial.coupling.attitude = trial.coupling.height = trial.coupling.prediction = false;
    printMapperRow(trial, "nothing", options);
    trial.coupling.prediction = true;
    printMapperRow(trial, "prediction", options);
    trial.coupling.attitude = trial.coupling.height = true;
    printMapperRow(trial, "everything", options);
  }
}

/// Prints how well the covariances of the filter fit its errors; see measure_flights.
void printConsistency(const std::vector<FilterMeasurement>& flights) {
  constexpr std::pair<double, double> kBand = {6.2621, 27.4884};  // chi-square, 15 degrees
  std::vector<double> all, means;
  std::array<double, 5> blocks{};
  for (std::size_t second = 0;; ++second) {
    std::vector<double> now;
    for (const FilterMeasurement& m : flights) {
      if (second < m.nees.size()) now.push_back(m.nees[second]);
    }
    if (now.empty()) break;
    all.insert(all.end(), now.begin(), now.end());
    if (now.size() == flights.size()) means.push_back(meanOf(now));
  }
  std::size_t count = 0;
  for (const FilterMeasurement& m : flights) {
    for (const auto& block : m.block_nees) {
      ++count;
      for (std::size_t i = 0; i < blocks.size(); ++i) blocks[i] += block[i];
    }
  }
  const auto band = meanNeesBand(flights.size(), kFilterDim);
  std::printf(
      "NEES of the 15 states: mean %.2f (expected 15); %.0f %% of the values are within the 95 %% "
      "band of %.1f to %.1f, %.0f %% below its upper limit; the mean over the flights is within "
      "its 95 %% band of %.2f to %.2f in %.0f %% of the seconds\n  NEES of orientation %.2f, "
      "position %.2f, velocity %.2f, gyro bias %.2f, accelerometer bias %.2f (expected 3)\n",
      meanOf(all), kPercent * shareWithin(all, kBand), kBand.first, kBand.second,
      kPercent * shareWithin(all, {0.0, kBand.second}), band.first, band.second,
      kPercent * shareWithin(means, band), blocks[0] / static_cast<double>(count),
      blocks[1] / static_cast<double>(count), blocks[2] / static_cast<double>(count),
      blocks[3] / static_cast<double>(count), blocks[4] / static_cast<double>(count));
}

void flyAtRandom(const Options& options) {
  std::vector<std::string> names;
  for (const Place& candidate : places()) {
    if (candidate.name == "hall" || candidate.name == "corridor") continue;
    if (candidate.name.find("town") == std::string::npos) names.push_back(candidate.name);
  }
  std::vector<FilterMeasurement> flights;
  std::array<double, 4> worst{};
  for (int i = 0; i < options.random_flights; ++i) {
    const auto number = static_cast<std::size_t>(i);
    FilterTrial trial = trialIn("random", names[number % names.size()]);
    trial.flight.seed = number + static_cast<std::size_t>(options.first_seed);
    trial.flight.place.plan = randomPlan(trial.flight.place, options.random_s, trial.flight.seed);
    const FilterMeasurement m = measure(trial, options);
    worst = {std::max(worst[0], m.xy_rmse_m), std::max(worst[1], m.z_rmse_m),
             std::max(worst[2], m.velocity_rmse), std::max(worst[3], m.tilt_rmse_deg)};
    constexpr double kBad = 0.05;  // m
    if (m.xy_rmse_m > kBad) {
      trial.flight.name = "random flight " + std::to_string(i) + " in " + trial.flight.place.name;
      printFilterRow(trial, m, options);
    }
    flights.push_back(m);
  }
  std::printf(
      "\n%d random flights of %.0f s: worst rmse xy %.4f m, z %.4f m, velocity %.4f m/s, roll and "
      "pitch %.3f°\n",
      options.random_flights, options.random_s, worst[0], worst[1], worst[2], worst[3]);
  printConsistency(flights);
}

void printErrors(const std::string& name, const char* who, const char* coupling,
                 const MovingErrors& errors) {
  std::printf("| %s | %s | %s | %zu | %.3f m | %.3f m/s |\n", name.c_str(), who, coupling,
              errors.count, errors.position_rmse_m, errors.velocity_rmse);
  std::fflush(stdout);
}

/// Compares mapper and filter with motion capture, on recordings.
void compareWithMotionCapture(const Options& options) {
  SlamConfig config;
  applySettings(options.settings, config);
  std::printf(
      "\n| recording | pose of | filter gives | poses | position rmse | velocity rmse "
      "|\n|---|---|---|---|---|---|\n");
  for (const std::string& path : options.bags) {
    const std::string name = std::filesystem::path(path).filename().string();
    const Trajectory reference = readReference(path, options.reference_topic);
    for (const bool coupled : {false, true}) {
      CouplingOptions coupling;
      coupling.attitude = coupling.height = coupling.prediction = coupled;
      RecordingOptions how_to_read;
      how_to_read.base_T_laser = laserPoseOf(options.laser_pose);
      const auto recording = openRecording(path, how_to_read);
      const RecordedFilterRun run = runFiltered(*recording, config, options.filter, coupling,
                                                laserPoseOf(options.laser_pose));
      const char* how = coupled ? "everything" : "nothing";
      printErrors(name, "mapper", how, compareWithReference(run.mapper, reference));
      printErrors(name, "filter", how, compareWithReference(run.filter, reference));
      if (options.counts) printCounts(run.status);
    }
  }
}

void run(Options options) {
  if (options.list_parameters) {
    std::fputs(defaultFilterParametersYaml().c_str(), stdout);
    return;
  }
  applySettings(options.filter_settings, parametersOf(options.filter));
  validate(options.filter);
  if (!options.bags.empty()) {
    compareWithMotionCapture(options);
    return;
  }
  flyWithTruth(options);
  if (options.hard_flights > 0) compareCoupling(options);
  if (options.random_flights > 0) flyAtRandom(options);
  if (options.cost_s > 0.0) {
    std::printf("\nprocessor time per IMU sample at 400 Hz, with delayed poses at 40 Hz: %.1f us\n",
                measureImuCost(options.cost_s));
  }
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  Options options;
  CLI::App app(
      "Runs the pose filter with projector and mapper on simulated flights and prints the errors "
      "with respect to the true states.");
  app.add_option("--hard", options.hard_flights, "number of hard flights of each kind")
      ->capture_default_str();
  app.add_option("--random", options.random_flights, "number of random flights")
      ->capture_default_str();
  app.add_option("--seed", options.first_seed,
                 "seed of the first hard flight and of the first random flight")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--random-duration", options.random_s, "duration of each random flight, s")
      ->capture_default_str();
  app.add_option("--cost-duration", options.cost_s,
                 "simulated time for the measurement of the processor time, s; 0: none")
      ->capture_default_str();
  app.add_option("--only", options.only, "run only flights whose name contains this text");
  app.add_flag("--counts", options.counts,
               "also print accepted and rejected measurements of each sensor");
  app.add_option("--recording", options.bags,
                 "instead of simulating, use these recordings with IMU and motion capture");
  app.add_option("--reference-topic", options.reference_topic, "topic of the motion capture");
  app.add_option("--set", options.settings,
                 "with --recording: name=value, sets a parameter, see map_recording")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--filter", options.filter_settings,
                 "name=value: sets a filter parameter, see --list-parameters")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  app.add_flag("--list-parameters", options.list_parameters,
               "print all parameters of the filter as YAML and exit");
  addLaserPoseOption(app, options.laser_pose);
  return runTool("measure_filter", app, argc, argv, [&] { run(options); });
}
