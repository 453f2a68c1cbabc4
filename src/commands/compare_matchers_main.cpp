// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/commands/mapping_command.h"
#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/experiments/evaluation_experiment.h"
#include "kestrel_slam/experiments/matcher_comparison.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/report/likelihood_plot.h"
#include "kestrel_slam/session/version.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  MappingArguments mapping;
  std::string output;
  std::string relations;
  std::vector<std::string> matchers = matcherNames();
  bool evaluation = false;
  std::size_t surface = 0;  ///< number of a scan; 0: none
  bool version = false;
};

void declareOptions(CLI::App& app, Arguments& arguments) {
  app.add_option(
      "--output", arguments.output,
      "output folder for the table, the plot, and the map and trajectory of each matcher");
  app.add_option(
      "--relations", arguments.relations,
      "file with lines `t1 t2 x y z roll pitch yaw`; if not given, the trajectories are compared "
      "with that of the default matcher");
  app.add_option("--matchers", arguments.matchers, "comma-separated names (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(matcherNames()));
  app.add_flag(
      "--evaluation", arguments.evaluation,
      "instead, measure how well the evaluation function separates good and bad matches; the "
      "matches start from displaced initial guesses");
  app.add_option("--surface", arguments.surface,
                 "N: instead, plot the likelihood of poses around the pose of the N-th scan")
      ->check(CLI::PositiveNumber);
  addMappingOptions(app, arguments.mapping);
  app.add_flag("--version", arguments.version, "print the version and exit");
}

std::vector<MethodRun> mapWithEach(const Arguments& arguments, SlamConfig config) {
  std::vector<MethodRun> runs;
  for (const std::string& method : arguments.matchers) {
    if (stopRequested()) break;
    if (!arguments.mapping.quiet) std::fprintf(stderr, "%s\n", method.c_str());
    config.mapper.matcher.method = method;
    const auto recording = openFor(arguments.mapping);
    const RunInfo info = runInfoOf(arguments.mapping, config, *recording);
    const fs::path folder = fs::path(arguments.output) / method;
    prepareOutput(folder);
    runs.push_back({method, mapWithProgress(*recording, config, arguments.mapping)});
    writeOutputs(folder, runs.back().run, info);
    printWarnings("warning: " + method + ": ", runs.back().run);
  }
  return runs;
}

void finish(const Arguments& arguments, const std::string& name, const std::string& table) {
  const std::string path = (fs::path(arguments.output) / name).string();
  writeFileAtomically(path + ".md", table);
  std::fputs(table.c_str(), stdout);
  if (arguments.mapping.quiet) return;
  std::printf("\ntable       %s.md\nplot        %s.png\n", path.c_str(), path.c_str());
}

void compare(const Arguments& arguments, const SlamConfig& config) {
  std::optional<std::vector<Relation>> relations;
  if (!arguments.relations.empty()) relations = readRelations(arguments.relations);
  prepareOutput(arguments.output);
  const std::vector<MethodRun> runs = mapWithEach(arguments, config);
  MatcherComparison comparison;
  try {
    comparison = compareRuns(runs, relations, SlamConfig().mapper.matcher.method);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(arguments.relations + ": " + error.what() +
                             "; check that the relations belong to " +
                             arguments.mapping.recording());
  }
  plotComparison((fs::path(arguments.output) / "comparison.png").string(), runs, comparison);
  finish(arguments, "comparison", comparisonTable(runs, comparison, !arguments.mapping.no_timing));
}

/// Maps the recording once and runs the experiments of all matchers on its scans.
void measureEvaluation(Arguments arguments, const SlamConfig& config) {
  prepareOutput(arguments.output);
  std::vector<EvaluationExperiment> experiments;
  for (const std::string& method : arguments.matchers) {
    experiments.emplace_back(config.mapper, method, ExperimentConfig());
  }
  arguments.mapping.run.observer = [&](const PlanarScan& scan, const MapperResult& result) {
    for (EvaluationExperiment& experiment : experiments) experiment.add(scan, result);
  };
  const auto recording = openFor(arguments.mapping);
  printWarnings("warning: ", mapWithProgress(*recording, config, arguments.mapping));
  std::vector<MethodTrials> methods;
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    methods.push_back({arguments.matchers[i], experiments[i].trials()});
  }
  const double threshold = config.mapper.evaluation.threshold;
  plotEvaluationFunction((fs::path(arguments.output) / "evaluation.png").string(), methods,
                         threshold);
  finish(arguments, "evaluation", evaluationTable(methods, threshold));
}

/// Maps up to the scan and plots the likelihood of the poses around its pose.
void drawLikelihood(Arguments arguments, const SlamConfig& config) {
  prepareOutput(arguments.output);
  LikelihoodRecorder recorder(config.mapper, arguments.surface);
  arguments.mapping.run.max_scans =
      std::min(arguments.mapping.run.max_scans, arguments.surface + 1);
  arguments.mapping.run.observer = [&](const PlanarScan& scan, const MapperResult& result) {
    recorder.add(scan, result);
  };
  const auto recording = openFor(arguments.mapping);
  printWarnings("warning: ", mapWithProgress(*recording, config, arguments.mapping));
  const std::string path = (fs::path(arguments.output) / "surface.png").string();
  recorder.write(path);
  if (!arguments.mapping.quiet) std::printf("plot        %s\n", path.c_str());
}

void run(const Arguments& arguments) {
  if (arguments.version) {
    std::puts(kVersion);
    return;
  }
  const SlamConfig config = configOf(arguments.mapping);
  openFor(arguments.mapping);  // reports errors before anything is written
  stopOnSignals();
  if (arguments.surface > 0) {
    drawLikelihood(arguments, config);
  } else if (arguments.evaluation) {
    measureEvaluation(arguments, config);
  } else {
    compare(arguments, config);
  }
}

void check(const Arguments& arguments) {
  if (arguments.version) return;
  if (arguments.mapping.recordings.empty()) throw CLI::RequiredError("RECORDING");
  if (arguments.output.empty()) throw CLI::RequiredError("--output");
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app(
      "Maps a recording with each matcher and compares the results in a table and a plot.");
  Arguments arguments;
  declareOptions(app, arguments);
  return runTool(
      "compare_matchers", app, argc, argv, [&] { run(arguments); }, [&] { check(arguments); });
}
