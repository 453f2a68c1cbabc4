// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/graph/g2o_file.h"
#include "kestrel_slam/graph/initial_poses.h"
#include "kestrel_slam/graph/optimizer.h"
#include "kestrel_slam/graph/robust_optimizer.h"

namespace kestrel {
namespace {

struct Options {
  std::string input, output;
  bool robust = false;
  bool reinitialize = false;
};

double chi2Of(const PoseGraph& graph) {
  return std::accumulate(
      graph.edges.begin(), graph.edges.end(), 0.0,
      [&](double sum, const PoseEdge& edge) { return sum + chi2Of(edge, graph); });
}

void printGraph(const PoseGraph& graph) {
  const auto loops = std::count_if(graph.edges.begin(), graph.edges.end(),
                                   [](const PoseEdge& e) { return e.kind == EdgeKind::kLoop; });
  std::printf("%zu vertices, %zu edges, %td of them loops, chi2 %.6g\n", graph.vertices.size(),
              graph.edges.size(), loops, chi2Of(graph));
}

void requireSolution(const OptimizerResult& result, const std::string& path) {
  if (!result.ok()) throw std::runtime_error(path + ": " + result.problem);
  std::printf("%s after %d steps\n", result.converged ? "converged" : "not converged",
              result.iterations);
}

void solvePlainly(const Options& options, PoseGraph& graph) {
  if (options.reinitialize && !placeByRotations(graph)) {
    throw std::runtime_error(options.input + ": the graph has no unique solution");
  }
  OptimizerOptions plain;
  plain.kernel_scale = 0.0;
  requireSolution(optimize(graph, plain), options.input);
}

/// Leaves only the accepted edges.
void solveRobustly(const Options& options, PoseGraph& graph) {
  const RobustResult result = optimizeRobustly(graph);
  requireSolution(result.optimizer, options.input);
  std::vector<PoseEdge> accepted;
  std::size_t loops = 0;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (!result.accepted[i]) continue;
    accepted.push_back(graph.edges[i]);
    if (graph.edges[i].kind == EdgeKind::kLoop) ++loops;
  }
  std::printf("loops: %zu accepted, %zu refused\n", loops, graph.edges.size() - accepted.size());
  graph.edges = std::move(accepted);
}

void run(const Options& options) {
  G2oGraph file = readG2o(options.input);
  printGraph(file.graph);
  if (options.robust) {
    solveRobustly(options, file.graph);
  } else {
    solvePlainly(options, file.graph);
  }
  printGraph(file.graph);
  writeG2o(options.output, file);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app(
      "Optimizes a planar pose graph: a g2o file with VERTEX_SE2, EDGE_SE2 and FIX.\n"
      "Exit code 0: done; 1: bad input; 2: wrong usage.");
  Options options;
  app.add_option("graph", options.input, "g2o file, not packed")->required();
  app.add_option("--output", options.output, "g2o file with the optimized poses")->required();
  auto* const robust =
      app.add_flag("--robust", options.robust,
                   "refuse false loops: those that contradict each other, the odometry or the "
                   "optimized graph. They are left out of the output");
  app.add_flag("--reinitialize", options.reinitialize,
               "ignore the poses of the file, and begin with those that linear least squares give; "
               "--robust always does so")
      ->excludes(robust);
  return runTool("optimize_graph", app, argc, argv, [&] { run(options); });
}
