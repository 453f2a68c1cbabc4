// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <istream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/experiments/graph_measurement.h"
#include "kestrel_slam/graph/g2o_file.h"
#include "kestrel_slam/graph/initial_poses.h"
#include "kestrel_slam/graph/optimizer.h"
#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

struct Options {
  std::string data;
  std::vector<int> percents = {10, 50, 100, 200};
  std::vector<std::string> only;
};

struct PublicGraph {
  const char* name;
  const char* file;
  double published;  ///< cost in [Rosen 2019], four digits; 0: none for this file
  bool has_false_loops;
};

constexpr PublicGraph kGraphs[] = {
    {"intel", "intel.g2o.xz", 52.35, true},
    {"CSAIL", "CSAIL.g2o", 31.70, false},
    {"manhattan", "manhattan_originalDataset_g2o_manhattanOlson3500.g2o.xz", 0.0, true},
    {"ring", "ring_originalDataset_ring.g2o", 0.0, true},
    {"ringCity", "ringCity_originalDataset_ringCity.g2o.xz", 0.0, true},
};

std::string textOf(const std::string& path) {
  const std::unique_ptr<std::istream> stream = openText(path);
  return {std::istreambuf_iterator<char>(*stream), std::istreambuf_iterator<char>()};
}

PoseGraph graphOf(const Options& options, const PublicGraph& graph) {
  const std::string path = options.data + "/" + graph.file;
  return parseG2o(textOf(path), path).graph;
}

void printOptimum(const PublicGraph& graph, const PoseGraph& poses) {
  const CertifiedOptimum optimum = certifiedOptimum(poses);
  std::printf("%-10s %8zu %8zu %12.7g %5d %8.1f %12.7g ", graph.name, poses.vertices.size(),
              poses.edges.size(), optimum.chi2, optimum.steps, optimum.milliseconds, optimum.cost);
  if (graph.published > 0.0) {
    std::printf("%9.2f ", graph.published);
  } else {
    std::printf("%9s ", "-");
  }
  std::printf("%12.1e\n", (optimum.cost - optimum.lower_bound) / optimum.cost);
}

void printScore(const char* graph, const char* kind, int percent, const RobustScore& score) {
  const auto share = [](std::size_t part, std::size_t all) {
    return all == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(all);
  };
  std::printf("%-10s %-8s %5d %6zu %6zu %7.2f %6zu %6zu %7.2f %9.2f %8.2f\n", graph, kind, percent,
              score.true_loops, score.true_accepted, share(score.true_accepted, score.true_loops),
              score.false_loops, score.false_accepted,
              share(score.false_accepted, score.false_loops), score.max_error_m, score.seconds);
  std::fflush(stdout);
}

PoseGraph optimumOf(PoseGraph graph) {
  OptimizerOptions plain;
  plain.kernel_scale = 0.0;
  placeByRotations(graph);
  optimize(graph, plain);
  return graph;
}

void printFalseLoops(const Options& options, const PublicGraph& graph, const PoseGraph& clean) {
  const PoseGraph reference = optimumOf(clean);
  std::size_t loops = 0;
  for (const PoseEdge& edge : clean.edges) loops += edge.kind == EdgeKind::kLoop ? 1 : 0;
  printScore(graph.name, "none", 0, scoreRobustly(clean, clean.edges.size(), reference));
  for (const FalseLoops kind :
       {FalseLoops::kRandom, FalseLoops::kLocal, FalseLoops::kGrouped, FalseLoops::kAliased}) {
    for (const int percent : options.percents) {
      PoseGraph damaged = reference;
      const std::size_t count = loops * static_cast<std::size_t>(percent) / 100;
      addFalseLoops(kind, count, static_cast<std::uint64_t>(percent), damaged);
      printScore(graph.name, toString(kind), percent,
                 scoreRobustly(damaged, clean.edges.size(), reference));
    }
  }
}

/// CSAIL as two robots: the first 128 loops of the file are true.
void printTwoRobots(const Options& options) {
  const std::string folder = options.data + "/CSAIL";
  const std::string robots =
      textOf(folder + "_robot1.g2o") + "\n" + textOf(folder + "_robot2.g2o") + "\n";
  const auto parsed = [&](const std::string& loops) {
    return parseG2o(robots + textOf(folder + loops), folder + loops).graph;
  };
  const std::size_t begin = parseG2o(robots, folder).graph.edges.size();
  const std::size_t end = parsed("_interrobot_loop_closures.g2o").edges.size();
  PoseGraph graph = parsed("_interrobot_loop_closures_outliers.g2o");
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    graph.edges[i].kind = i < begin ? EdgeKind::kOdometry : EdgeKind::kLoop;
  }
  PoseGraph clean = graph;
  clean.edges.resize(end);
  printScore("CSAIL", "2 robots", 195, scoreRobustly(graph, end, optimumOf(clean)));
}

bool wanted(const Options& options, const std::string& name) {
  if (options.only.empty()) return true;
  return std::find(options.only.begin(), options.only.end(), name) != options.only.end();
}

void run(const Options& options) {
  std::printf("%-10s %8s %8s %12s %5s %8s %12s %9s %12s\n", "graph", "vertices", "edges", "chi2",
              "steps", "ms", "SE-Sync cost", "published", "gap at most");
  for (const PublicGraph& graph : kGraphs) {
    if (wanted(options, graph.name)) printOptimum(graph, graphOf(options, graph));
  }
  std::printf("\n%-10s %-8s %5s %6s %6s %7s %6s %6s %7s %9s %8s\n", "graph", "false", "%", "true",
              "found", "%", "false", "taken", "%", "max err m", "s");
  if (wanted(options, "CSAIL")) printTwoRobots(options);
  for (const PublicGraph& graph : kGraphs) {
    if (!graph.has_false_loops || !wanted(options, graph.name)) continue;
    printFalseLoops(options, graph, graphOf(options, graph));
  }
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app(
      "Measures the optimizer and the robust back end on public pose graphs.\n"
      "Exit code 0: done; 1: bad input; 2: wrong usage.");
  Options options;
  app.add_option("data", options.data, "folder with the graphs (g2o, may be packed with xz)")
      ->required();
  app.add_option("--percent", options.percents, "false loops, in percent of the true ones")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--only", options.only, "intel, CSAIL, manhattan, ring or ringCity");
  return runTool("measure_graphs", app, argc, argv, [&] { run(options); });
}
