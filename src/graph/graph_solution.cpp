// SPDX-License-Identifier: BSD-3-Clause
// The optimization of a submap graph, and its last refinement.
#include <algorithm>
#include <limits>
#include <vector>

#include "kestrel_slam/graph/optimizer.h"
#include "kestrel_slam/graph/submap_graph.h"

namespace kestrel {
namespace {

/// A loop with less than this weight after the optimization is taken back.
constexpr double kLeastWeight = 0.2;
/// At the end, one of so many keyframes is matched with so many places that are nearer than this.
constexpr std::size_t kRefineEvery = 3;
constexpr int kRefinePlaces = 3;
constexpr double kRefineM = 3.0, kRefineRadiusM = 0.3;
/// Not a loop.
constexpr std::size_t kNoVertex = std::numeric_limits<std::size_t>::max();

}  // namespace

void SubmapGraph::solve() {
  unsolved_ = 0;
  ++solutions_;
  track_.learn(chain_);
  do {
    PoseGraph joint = graph_;
    const OdometrySelection tracked = track_.addTo(joint, chain_, doubtful_);
    const OptimizerResult result = optimize(joint);
    track_.place(tracked, joint);
    std::copy_n(joint.vertices.begin(), graph_.vertices.size(), graph_.vertices.begin());
    weights_ = result.edge_weights;
    if (!result.ok()) return;
    weights_.resize(graph_.edges.size());
    if (!takeBack(weights_)) return;
  } while (true);
}

PoseGraph SubmapGraph::withOdometry() const {
  PoseGraph result = graph_;
  track_.addTo(result, chain_, doubtful_);
  return result;
}

/// Takes loops back that the others contradict. Returns whether there was one.
bool SubmapGraph::takeBack(const std::vector<double>& weights) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < graph_.edges.size(); ++i) {
    if (loop_of_edge_[i] != kNoVertex && weights[i] < kLeastWeight) {
      Loop& loop = loops_[loop_of_edge_[i]];
      loop.state = LoopState::kUndone;
      loop.reason = "the optimized graph contradicts it";
      continue;
    }
    graph_.edges[kept] = graph_.edges[i];
    loop_of_edge_[kept++] = loop_of_edge_[i];
  }
  const bool any = kept < graph_.edges.size();
  loop_of_edge_.resize(kept);
  graph_.edges.resize(kept);
  if (any) joined_ = connectedParts(graph_);
  return any;
}

void SubmapGraph::refine() {
  if (graph_.edges.size() == odometry_.edges.size() && track_.empty()) return;  // no loop
  solve();
  std::vector<int> matched(keyframes_.size(), 0);
  unsolved_ = 0;
  for (std::size_t place = 0; place < places_.all().size(); ++place) refineAt(place, matched);
  solve();
}

/// Matches keyframes of other visits with the place. `matched`: how often each keyframe was.
void SubmapGraph::refineAt(std::size_t number, std::vector<int>& matched) {
  const KnownPlace& place = places_.all()[number];
  for (std::size_t query = 0; query < keyframes_.size(); query += kRefineEvery) {
    if (isNeighbor(place, query) || joined_[place.first] != joined_[query]) continue;
    if (matched[query] >= kRefinePlaces || std::max(place.last, query + 1) <= loaded_) continue;
    const Candidate candidate = candidateAt(number, query);
    if (candidate.distance_m > kRefineM) continue;
    const Loop loop = matcher_.matchExpected(places_.mapOf(number, keyframes_), place, keyframes_,
                                             query, expectedAt(candidate, query), kRefineRadiusM);
    if (loop.state != LoopState::kAccepted) continue;
    ++matched[query];
    loops_.push_back(loop);
    graph_.edges.push_back(graphEdgeOf(loop));
    loop_of_edge_.push_back(loops_.size() - 1);
  }
}

}  // namespace kestrel
