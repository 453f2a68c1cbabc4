// SPDX-License-Identifier: BSD-3-Clause
#include "joint_solution.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "kestrel_slam/graph/optimizer.h"
#include "kestrel_slam/merging/map_merger.h"

namespace kestrel {
namespace {

/// A pair is contradicted if the loops between its vehicles have a smaller mean weight.
constexpr double kLeastWeight = 0.3;
/// The solution has converged when a step lowers the cost by a smaller share. With 10 000 loops
/// that is a chi2 of 0.01, far less than the loops can tell.
constexpr double kMinDecrease = 1e-6;
/// So many of the refined loops of a pair are used, evenly distributed over the way: those of
/// neighboring keyframes say nearly the same.
constexpr std::size_t kMostRefined = 1000;
/// Error of a pose that was given.
constexpr double kGivenM = 0.5, kGivenRad = 0.1;

/// map_a_T_map_b by one loop, with the poses of `graph`.
Pose2 mapPose(const JointMap& joint, const PoseGraph& graph, std::size_t a, const Loop& loop) {
  const Pose2 anchor_T_query = loop.anchor_T_query.mean;
  const Pose2 &anchor = graph.vertices[loop.anchor].pose, &query = graph.vertices[loop.query].pose;
  const bool anchor_in_a = joint.parts()[a].contains(loop.anchor);
  return anchor_in_a ? anchor * anchor_T_query * query.inverse()
                     : query * anchor_T_query.inverse() * anchor.inverse();
}

}  // namespace

OptimizerOptions jointOptions() {
  OptimizerOptions options;
  options.min_decrease = kMinDecrease;
  return options;
}

std::vector<PoseVertex> joinedByLoops(const JointMap& joint, std::size_t a, std::size_t b,
                                      const std::vector<Loop>& loops,
                                      const std::vector<Loop>& refined) {
  JointSolution solution(joint, a, b);
  solution.join(0, a, b, loops, refined);
  solution.solve();
  return solution.graph().vertices;
}

Loop givenLoop(const JointMap& joint, std::size_t a, std::size_t b, const Pose2& a_T_b) {
  Loop loop;
  loop.anchor = joint.parts()[a].first;
  loop.query = joint.parts()[b].first;
  loop.anchor_T_query.mean = joint.poseOf(loop.anchor).between(a_T_b * joint.poseOf(loop.query));
  loop.anchor_T_query.covariance.diagonal() =
      Eigen::Vector3d(kGivenM, kGivenM, kGivenRad).cwiseAbs2();
  loop.state = LoopState::kAccepted;
  return loop;
}

JointSolution::JointSolution(const JointMap& joint)
    : joint_(joint), graph_(joint.graph()), groups_(joint.parts().size()) {
  std::iota(groups_.begin(), groups_.end(), 0U);
}

JointSolution::JointSolution(const JointMap& joint, std::size_t a, std::size_t b)
    : JointSolution(joint) {
  const JointMap::Part &first = joint.parts()[a], &second = joint.parts()[b];
  const auto is_other = [&](const PoseEdge& edge) {
    return !first.contains(edge.from) && !second.contains(edge.from);
  };
  graph_.edges.erase(std::remove_if(graph_.edges.begin(), graph_.edges.end(), is_other),
                     graph_.edges.end());
}

void JointSolution::join(std::size_t pair, std::size_t a, std::size_t b,
                         const std::vector<Loop>& loops, const std::vector<Loop>& refined) {
  if (loops.empty()) return;
  if (groups_[a] != groups_[b]) {
    const Pose2 a_T_b = mapPose(joint_, graph_, a, loops[loops.size() / 2]);
    if (groups_[a] < groups_[b]) {
      move(groups_[b], groups_[a], a_T_b);
    } else {
      move(groups_[a], groups_[b], a_T_b.inverse());
    }
  }
  const auto add = [&](const Loop& loop, bool is_refined) {
    edges_.push_back({graph_.edges.size(), pair, is_refined});
    graph_.edges.push_back(graphEdgeOf(loop));
  };
  for (const Loop& loop : loops) add(loop, false);
  const std::size_t step = refined.size() / kMostRefined + 1;
  for (std::size_t i = 0; i < refined.size(); i += step) add(refined[i], true);
}

void JointSolution::move(std::size_t group, std::size_t onto, const Pose2& onto_T_group) {
  for (std::size_t v = 0; v < groups_.size(); ++v) {
    if (groups_[v] != group) continue;
    for (std::size_t i = joint_.parts()[v].first; i < joint_.parts()[v].last; ++i)
      graph_.vertices[i].pose = onto_T_group * graph_.vertices[i].pose;
    groups_[v] = onto;
  }
}

void JointSolution::solve() {
  const OptimizerResult result = optimize(graph_, jointOptions());
  weights_ = result.ok() ? result.edge_weights : std::vector<double>(graph_.edges.size(), 0.0);
}

std::vector<std::size_t> JointSolution::contradicted() const {
  std::map<std::size_t, std::pair<double, double>> sums;  // by pair: weights and number
  for (const Between& between : edges_) {
    if (between.refined) continue;
    sums[between.pair].first += weights_[between.edge];
    sums[between.pair].second += 1.0;
  }
  std::vector<std::pair<double, std::size_t>> worst;
  for (const auto& [pair, sum] : sums) {
    const double mean = sum.first / sum.second;
    if (mean < kLeastWeight) worst.emplace_back(mean, pair);
  }
  std::sort(worst.begin(), worst.end());
  std::vector<std::size_t> pairs;
  for (const auto& [mean, pair] : worst) pairs.push_back(pair);
  return pairs;
}

}  // namespace kestrel
