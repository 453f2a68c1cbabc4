// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>

#include "kestrel_slam/commands/mapping_command.h"
#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/offline/stats.h"
#include "kestrel_slam/offline/version.h"
#include "kestrel_slam/parameters/parameters_yaml.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  MappingArguments mapping;
  std::string output;
  bool list_parameters = false;
  bool version = false;
};

void declareOptions(CLI::App& app, Arguments& arguments) {
  app.add_option(
      "--output", arguments.output,
      "output folder for map, trajectory, statistics and report (default: ./<name>_map)");
  addMappingOptions(app, arguments.mapping);
  addSessionOptions(app, arguments.mapping);
  app.add_flag("--list-parameters", arguments.list_parameters,
               "print all parameters as YAML, with the values of --config and --set or else their "
               "defaults, and exit");
  app.add_flag("--version", arguments.version, "print the version and exit");
}

void printSummary(const fs::path& folder, const std::string& session, const OfflineRun& run) {
  const std::size_t scans = run.scans.size();
  const MatchSummary match = summarize(run.scans);
  std::printf("%-12s%zu processed, %zu dropped, %zu lost\n", "scans", scans, run.droppedCount(),
              match.lost);
  std::printf("%-12s%.1f m in %.0f s\n", "distance", run.distance_m, run.duration_s);
  std::printf("%-12s%.3f ms per scan, %.0f x real time, %.0f MB\n", "time", scanTimes(run).mean,
              run.speedFactor(), run.peak_memory_mb);
  for (const auto& [what, file] : {std::pair{"map", "map.yaml"},
                                   {"trajectory", "trajectory.tum"},
                                   {"covariances", "covariances.txt"},
                                   {"states", "scans.csv"},
                                   {"statistics", "stats.json"},
                                   {"report", "report.html"}}) {
    std::printf("%-12s%s\n", what, (folder / file).string().c_str());
  }
  if (!session.empty()) std::printf("%-12s%s\n", "session", session.c_str());
}

void mapRecording(const Arguments& arguments) {
  const MappingArguments& mapping = arguments.mapping;
  const SlamConfig config = configOf(mapping);
  stopOnSignals();
  const auto recording = openFor(mapping);
  const RunInfo info = runInfoOf(mapping, config, *recording);
  const fs::path folder =
      arguments.output.empty() ? nameOf(mapping.recording()) + "_map" : arguments.output;
  prepareOutput(folder);
  const OfflineRun run = mapWithProgress(*recording, config, mapping);
  writeOutputs(folder, run, info);
  saveSessionOf(run, mapping);
  printWarnings("warning: ", run);
  if (!mapping.quiet) printSummary(folder, mapping.save_session, run);
}

std::string parametersText(const MappingArguments& mapping) {
  if (mapping.config.empty() && mapping.settings.empty()) return defaultParametersYaml();
  return parametersYaml(configOf(mapping));
}

void run(const Arguments& arguments) {
  if (arguments.version) {
    std::puts(kVersion);
  } else if (arguments.list_parameters) {
    std::fputs(parametersText(arguments.mapping).c_str(), stdout);
  } else {
    mapRecording(arguments);
  }
}

void check(const Arguments& arguments) {
  if (arguments.mapping.recordings.empty() && !arguments.list_parameters && !arguments.version) {
    throw CLI::RequiredError("RECORDING");
  }
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app("Maps a recording of a 2D laser and writes the map, the trajectory and a report.");
  Arguments arguments;
  declareOptions(app, arguments);
  return runTool(
      "map_recording", app, argc, argv, [&] { run(arguments); }, [&] { check(arguments); });
}
