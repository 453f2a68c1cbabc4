// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/evaluation/covariance_file.h"
#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/evaluation/scan_file.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/recording/reference.h"
#include "kestrel_slam/recording/trajectory.h"
#include "kestrel_slam/report/evaluation_plot.h"

namespace kestrel {
namespace {

struct Options {
  std::string trajectory, relations, covariances, odometry, scans, reference, reference_topic, json,
      plot;
};

struct Results {
  Trajectory trajectory;
  std::optional<RelationEvaluation> relations;
  std::optional<CovarianceEvaluation> covariances;
  std::optional<RelationNoise> noise;
  std::optional<ReferenceEvaluation> reference;
  std::optional<StateEvaluation> states;
};

void printRow(const char* name, const ErrorStatistics& s, const char* unit) {
  std::printf("%-30s %6zu %9.4f %9.4f %9.4f %9.4f %9.4f  %s\n", name, s.count, s.mean, s.std,
              s.median, s.max, s.rmse, unit);
}

void printRows(const std::string& name, const PoseErrorStatistics& statistics) {
  printRow((name + ", translation").c_str(), statistics.translation_m, "m");
  printRow((name + ", rotation").c_str(), statistics.rotation_deg, "deg");
}

void printStates(const StateEvaluation& states) {
  if (states.odometry_ate) printRows("ATE of the odometry", *states.odometry_ate);
  std::printf(
      "%zu scans ok, %zu degraded, %zu lost; %zu ok, but wrong by more than %.0f m since %zu "
      "scans before\n",
      states.ok, states.degraded, states.lost, states.wrong_and_ok, kWrongMotion, kMotionScans);
}

void printTable(const Results& results) {
  std::printf("%zu poses, path length %.2f m\n", results.trajectory.size(),
              pathLength(results.trajectory));
  if (!results.relations && !results.reference) return;
  std::printf("%-30s %6s %9s %9s %9s %9s %9s\n", "", "count", "mean", "std", "median", "max",
              "rmse");
  if (results.relations) {
    printRows("relations", results.relations->all);
    printRows("relations > 60 s", results.relations->distant);
  }
  if (results.covariances) {
    printRow("error / sigma, translation", results.covariances->translation, "");
    printRow("error / sigma, rotation", results.covariances->rotation, "");
    printRow("NEES of the relations", results.covariances->nees, "(expected mean: 3)");
  }
  if (results.noise) {
    std::printf(
        "noise of %zu relations up to %.0f s: relations %.4f m, trajectory %.4f m, "
        "odometry %.4f m\n",
        results.noise->count, kShortRelation, results.noise->relations_m,
        results.noise->trajectory_m, results.noise->odometry_m);
  }
  if (results.reference) {
    printRows("ATE", results.reference->ate_statistics);
    printRows("RPE per 1 m", results.reference->rpe_per_meter);
    printRows("RPE per 1 s", results.reference->rpe_per_second);
  }
  if (results.states) printStates(*results.states);
}

void printUnmatched(const Results& results) {
  if (results.relations && !results.relations->unmatched.empty()) {
    std::fprintf(stderr,
                 "warning: %zu relations omitted: %zu of their stamps are not in the trajectory, "
                 "the first one is %.6f\n",
                 results.relations->skipped_relations, results.relations->unmatched.size(),
                 results.relations->unmatched.front());
  }
  if (results.reference && results.reference->unmatched > 0) {
    std::fprintf(stderr,
                 "warning: %zu poses omitted: the reference has no pose near their stamps\n",
                 results.reference->unmatched);
  }
}

nlohmann::json toJson(const ErrorStatistics& s) {
  return {{"count", s.count},   {"mean", s.mean}, {"std", s.std},
          {"median", s.median}, {"max", s.max},   {"rmse", s.rmse}};
}

nlohmann::json toJson(const PoseErrorStatistics& s) {
  return {{"translation_m", toJson(s.translation_m)}, {"rotation_deg", toJson(s.rotation_deg)}};
}

void writeJson(const std::string& path, const Results& results) {
  nlohmann::json json = {{"poses", results.trajectory.size()},
                         {"path_length_m", pathLength(results.trajectory)}};
  if (results.relations) {
    json["relations"] = {{"all", toJson(results.relations->all)},
                         {"over_60_s", toJson(results.relations->distant)},
                         {"left_out", results.relations->skipped_relations},
                         {"unmatched_stamps", results.relations->unmatched}};
  }
  if (results.covariances) {
    json["claims"] = {{"translation_sigmas", toJson(results.covariances->translation)},
                      {"rotation_sigmas", toJson(results.covariances->rotation)},
                      {"nees", toJson(results.covariances->nees)}};
  }
  if (results.noise) {
    json["noise"] = {{"count", results.noise->count},
                     {"relations_m", results.noise->relations_m},
                     {"trajectory_m", results.noise->trajectory_m},
                     {"odometry_m", results.noise->odometry_m}};
  }
  if (results.reference) {
    json["reference"] = {{"ate", toJson(results.reference->ate_statistics)},
                         {"rpe_per_1_m", toJson(results.reference->rpe_per_meter)},
                         {"rpe_per_1_s", toJson(results.reference->rpe_per_second)},
                         {"unmatched_poses", results.reference->unmatched}};
  }
  if (results.states) {
    json["states"] = {{"ok", results.states->ok},
                      {"degraded", results.states->degraded},
                      {"lost", results.states->lost},
                      {"wrong_and_ok", results.states->wrong_and_ok}};
    if (results.states->odometry_ate) {
      json["states"]["odometry_ate"] = toJson(*results.states->odometry_ate);
    }
  }
  writeFileAtomically(path, json.dump(2) + "\n");
}

Results evaluate(const Options& options) {
  Results results;
  results.trajectory = readTum(options.trajectory);
  if (!options.relations.empty()) {
    results.relations = evaluateRelations(results.trajectory, readRelations(options.relations));
    if (results.relations->errors.empty()) {
      throw std::runtime_error(options.relations + ": no relation has both stamps in " +
                               options.trajectory +
                               "; check that both files belong to the same recording");
    }
  }
  if (!options.covariances.empty()) {
    results.covariances =
        evaluateCovariances(readCovariances(options.covariances), readRelations(options.relations));
  }
  if (!options.odometry.empty()) {
    results.noise =
        noiseOf(readRelations(options.relations), results.trajectory, readTum(options.odometry));
  }
  if (!options.reference.empty()) {
    try {
      const Trajectory reference = readReference(options.reference, options.reference_topic);
      results.reference = evaluateReference(results.trajectory, reference);
      if (!options.scans.empty()) {
        results.states = evaluateStates(readScans(options.scans), reference);
      }
    } catch (const ReferenceMismatch& error) {
      throw std::runtime_error(options.reference + ": " + error.what());
    }
  }
  return results;
}

/// A comparison of a few poses says nothing about the trajectory.
void requireOverlap(const Results& results) {
  constexpr double kMinShare = 0.1;
  if (!results.reference) return;
  const auto all = static_cast<double>(results.trajectory.size());
  const double share = 1.0 - static_cast<double>(results.reference->unmatched) / all;
  if (share >= kMinShare) return;
  throw std::runtime_error("only " + std::to_string(static_cast<int>(100.0 * share)) +
                           " % of the poses have a reference near their stamp; check that both "
                           "files belong to the same recording and use the same clock");
}

void run(const Options& options) {
  const Results results = evaluate(options);
  printTable(results);
  std::fflush(stdout);
  printUnmatched(results);
  if (!options.json.empty()) writeJson(options.json, results);
  if (!options.plot.empty()) {
    plotEvaluation(options.plot, std::filesystem::path(options.trajectory).filename().string(),
                   results.trajectory, results.relations, results.reference);
  }
  requireOverlap(results);
}

void check(const Options& options) {
  if (options.relations.empty() && options.reference.empty()) {
    throw CLI::RequiredError("--relations or --reference");
  }
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app(
      "Compares a trajectory with relations (Freiburg benchmark) or a reference trajectory.\n"
      "Exit code 0: done; 1: bad input; 2: wrong usage.");
  Options options;
  app.add_option("trajectory", options.trajectory, "trajectory to evaluate, TUM format")
      ->required();
  app.add_option("--relations", options.relations, "file with lines `t1 t2 x y z roll pitch yaw`");
  app.add_option("--covariances", options.covariances,
                 "covariances.txt of map_recording; compares the errors of the relations with "
                 "their covariances")
      ->needs("--relations");
  app.add_option("--odometry", options.odometry,
                 "odometry of the same recording, TUM format; compares all three, which shows the "
                 "noise of the relations themselves")
      ->needs("--relations");
  app.add_option("--reference", options.reference, "reference trajectory, TUM format or rosbag");
  app.add_option("--scans", options.scans,
                 "scans.csv of map_recording; counts the scans of each state, and those that are "
                 "wrong but called ok")
      ->needs("--reference");
  app.add_option("--reference-topic", options.reference_topic,
                 "topic in a rosbag: PoseStamped, PoseWithCovarianceStamped or Odometry");
  app.add_option("--json", options.json, "write all statistics to this file");
  app.add_option("--plot", options.plot,
                 "write a plot of trajectory and errors (PNG, and SVG beside it)");
  return runTool(
      "evaluate_trajectory", app, argc, argv, [&] { run(options); }, [&] { check(options); });
}
