// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/robust_optimizer.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "kestrel_slam/graph/initial_poses.h"
#include "kestrel_slam/graph/marginals.h"

namespace kestrel {
namespace {

/// Two explanations are similar if the second has more than this share of the loops of the first.
constexpr double kSimilar = 0.5;

/// The edges of loops by the pair of parts that they join.
using LoopsByParts = std::map<std::pair<std::size_t, std::size_t>, std::vector<std::size_t>>;

LoopsByParts loopsByParts(const PoseGraph& graph, const OdometryChain& chain) {
  LoopsByParts loops;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const PoseEdge& edge = graph.edges[i];
    if (edge.kind != EdgeKind::kLoop) continue;
    const std::size_t a = chain.partOf(edge.from), b = chain.partOf(edge.to);
    loops[{std::min(a, b), std::max(a, b)}].push_back(i);
  }
  return loops;
}

/// The share of all relative poses, those of false loops, whose error has a chi2 up to `max_chi2`.
class Chance {
 public:
  Chance(const OdometryChain& chain, double max_chi2) {
    Eigen::AlignedBox2d box;
    for (std::size_t i = 0; i < chain.size(); ++i) box.extend(chain.pose(i).translation());
    const double all = std::max(box.isEmpty() ? 0.0 : box.volume(), kMinArea) * 2.0 * kPi;
    factor_ = 4.0 / 3.0 * kPi * std::pow(max_chi2, 1.5) / all;  // ellipsoid with unit covariance
  }

  double of(double spread) const { return factor_ * spread; }

 private:
  static constexpr double kMinArea = 100.0;  // m²: a building has more than the way through it
  double factor_;
};

/// The cycle of a loop and the way between its vertices through an optimized graph.
std::optional<CycleCheck> checkCycle(const PoseEdge& loop, const GraphMarginals& marginals) {
  const std::optional<GaussianPose2> pose = marginals.between(loop.from, loop.to);
  if (!pose) return std::nullopt;
  const Eigen::Vector3d error = loop.measured.between(pose->mean).log();
  const Eigen::LLT<Eigen::Matrix3d> factor(pose->covariance + loop.information.inverse());
  const Eigen::Matrix3d root = factor.matrixL();
  return CycleCheck{error.dot(factor.solve(error)), root.diagonal().prod()};
}

/// Edges of loops.
using Cluster = std::vector<std::size_t>;
using Clusters = std::vector<Cluster>;

constexpr std::size_t kSamples = 9;  // of a cluster

/// Of a cluster with the optimized graph: kClose is more than chance explains.
enum class Agreement { kNone, kVague, kClose };

enum class Verdict { kOpen, kAccepted, kRefused };

class RobustOptimization {
 public:
  RobustOptimization(PoseGraph& graph, const RobustOptions& options)
      : graph_(graph),
        options_(options),
        chain_(graph),
        chance_(chain_, options.max_chi2),
        verdicts_(graph.edges.size(), Verdict::kAccepted) {
    for (std::size_t i = 0; i < verdicts_.size(); ++i) {
      if (graph.edges[i].kind == EdgeKind::kLoop) loops_.push_back(i);
    }
    for (const std::size_t i : loops_) verdicts_[i] = Verdict::kOpen;
  }

  RobustResult run() {
    choose();
    for (int round = 0; round < options_.max_rounds; ++round) {
      if (!optimizeAccepted()) break;
      if (!refuseAccepted() && !judgeOpen() && !chooseAgain()) break;
    }
    for (const Verdict verdict : verdicts_) {
      result_.accepted.push_back(verdict == Verdict::kAccepted);
    }
    return std::move(result_);
  }

 private:
  void choose() {
    result_.first = result_.second = 0;
    Clusters clusters;
    for (const auto& [parts, edges] : loopsByParts(graph_, chain_)) {
      for (Cluster& cluster : consistentClusters(edges)) clusters.push_back(std::move(cluster));
    }
    std::stable_sort(clusters.begin(), clusters.end(),
                     [](const Cluster& a, const Cluster& b) { return a.size() > b.size(); });
    acceptLargestFirst(std::move(clusters));
  }

  /// Accepts the clusters one after the other. Each is compared with the graph that the larger ones
  /// have given: where the odometry alone is too vague to refute a false cluster, this graph may
  /// not be.
  void acceptLargestFirst(Clusters clusters) {
    while (!clusters.empty()) {
      accept(clusters.front());
      clusters.erase(clusters.begin());
      if (clusters.empty() || !optimizeAccepted()) return;
      const GraphMarginals marginals(acceptedGraph(), result_.optimizer.edge_weights);
      Clusters open;
      for (const Cluster& cluster : clusters) {
        const Agreement agreement = agreementOf(cluster, marginals);
        if (agreement == Agreement::kClose) accept(cluster);
        if (agreement == Agreement::kVague) open.push_back(cluster);
      }
      clusters = std::move(open);
    }
  }

  void accept(const Cluster& cluster) {
    for (const std::size_t edge : cluster) verdicts_[edge] = Verdict::kAccepted;
  }

  /// By some of the loops of a cluster, which agree with each other.
  Agreement agreementOf(const Cluster& cluster, const GraphMarginals& marginals) const {
    const std::size_t step = (cluster.size() + kSamples - 1) / kSamples;
    std::size_t samples = 0, agreeing = 0, close = 0;
    for (std::size_t i = 0; i < cluster.size(); i += step, ++samples) {
      const auto cycle = checkCycle(graph_.edges[cluster[i]], marginals);
      if (cycle && !(cycle->chi2 <= options_.max_chi2)) continue;
      ++agreeing;
      if (cycle && isUnlikely(chance_.of(cycle->spread))) ++close;
    }
    if (2 * agreeing <= samples) return Agreement::kNone;
    return 2 * close > samples ? Agreement::kClose : Agreement::kVague;
  }

  /// Without the loops that the optimized graph contradicts. Returns whether more are accepted.
  bool chooseAgain() {
    const auto open = std::count(verdicts_.begin(), verdicts_.end(), Verdict::kOpen);
    if (open == 0 || refused_ == refused_before_) return false;
    refused_before_ = refused_;
    choose();
    return std::count(verdicts_.begin(), verdicts_.end(), Verdict::kOpen) < open;
  }

  void refuse(std::size_t edge) {
    verdicts_[edge] = Verdict::kRefused;
    ++refused_;
  }

  /// The supported loops of the largest consistent set, in clusters that support each other.
  Clusters consistentClusters(const std::vector<std::size_t>& edges) {
    ConsistentLoops loops(options_.consistency);
    std::vector<std::size_t> numbered;
    for (const std::size_t edge : edges) {
      if (verdicts_[edge] == Verdict::kRefused) continue;
      const auto alone = kestrel::checkCycle(graph_.edges[edge], chain_);
      if (alone && !(alone->chi2 <= options_.max_chi2)) continue;  // the odometry contradicts it
      loops.add(graph_.edges[edge], chain_);
      numbered.push_back(edge);
    }
    const Explanations found = loops.explain();
    result_.first += found.first.size();
    result_.second += found.second.size();
    result_.exact = result_.exact && found.exact;
    const double limit = kSimilar * static_cast<double>(found.first.size());
    if (static_cast<double>(found.second.size()) > limit) return {};
    std::vector<std::size_t> set;
    for (const std::size_t loop : found.first) set.push_back(numbered[loop]);
    return clustersOf(numbered, set);
  }

  Clusters clustersOf(const std::vector<std::size_t>& edges, const std::vector<std::size_t>& set) {
    PoseGraph links;  // one vertex for each loop of the set, one edge where two are close
    links.vertices.resize(set.size());
    std::vector<bool> supported;
    for (std::size_t i = 0; i < set.size(); ++i) {
      std::vector<std::size_t> close;
      supported.push_back(isSupported(set[i], edges, set, close));
      for (const std::size_t k : close) {
        PoseEdge& link = links.edges.emplace_back();
        link.from = i;
        link.to = k;
      }
    }
    std::map<std::size_t, Cluster> clusters;
    const std::vector<std::size_t> parts = connectedParts(links);
    for (std::size_t i = 0; i < set.size(); ++i) {
      if (supported[i]) clusters[parts[i]].push_back(set[i]);
    }
    Clusters result;
    for (auto& [part, cluster] : clusters) result.push_back(std::move(cluster));
    return result;
  }

  /// By the odometry and by loops of the set (all of which are consistent with it), more of which
  /// are so close than chance explains. `edges`: all loops that could have agreed. Fills in
  /// the indices in `set` of those that alone are close enough.
  bool isSupported(std::size_t edge, const std::vector<std::size_t>& edges,
                   const std::vector<std::size_t>& set, std::vector<std::size_t>& close) const {
    const auto alone = kestrel::checkCycle(graph_.edges[edge], chain_);
    const double of_odometry = alone ? std::min(1.0, chance_.of(alone->spread)) : 1.0;
    std::vector<std::pair<double, bool>> chances;  // of each loop, and whether it is of the set
    for (const std::size_t other : edges) {
      const auto cycle = checkCycle(graph_.edges[edge], graph_.edges[other], chain_);
      if (other == edge || !cycle) continue;
      const auto place = std::lower_bound(set.begin(), set.end(), other);
      const bool agrees = place != set.end() && *place == other;
      chances.emplace_back(chance_.of(cycle->spread), agrees);
      if (agrees && isUnlikely(chances.back().first)) {
        close.push_back(static_cast<std::size_t>(place - set.begin()));
      }
    }
    std::sort(chances.begin(), chances.end());
    // Of the n closest loops m agree. By chance: a Poisson distribution with the mean n p.
    double tail = 1.0, agreeing = 0.0;
    for (std::size_t i = 0; i < chances.size() && !isUnlikely(of_odometry * tail); ++i) {
      if (!chances[i].second) continue;
      agreeing += 1.0;
      const double mean = static_cast<double>(i + 1) * chances[i].first;
      if (mean >= agreeing) break;
      tail = std::min(tail, std::exp(agreeing * std::log(mean) - std::lgamma(agreeing + 1.0)));
    }
    return isUnlikely(of_odometry * tail);
  }

  bool isUnlikely(double chance) const { return chance <= options_.max_chance; }

  PoseGraph acceptedGraph() const {
    PoseGraph accepted;
    accepted.vertices = graph_.vertices;
    for (std::size_t i = 0; i < verdicts_.size(); ++i) {
      if (verdicts_[i] == Verdict::kAccepted) accepted.edges.push_back(graph_.edges[i]);
    }
    return accepted;
  }

  bool optimizeAccepted() {
    PoseGraph accepted = acceptedGraph();
    placeByRotations(accepted);
    result_.optimizer = optimize(accepted, options_.optimizer);
    if (result_.optimizer.ok()) graph_.vertices = std::move(accepted.vertices);
    return result_.optimizer.ok();
  }

  /// Accepted loops that do not fit into the optimized graph. Returns whether there is one.
  bool refuseAccepted() {
    const std::size_t before = refused_;
    for (const std::size_t i : loops_) {
      if (verdicts_[i] != Verdict::kAccepted) continue;
      if (!(chi2Of(graph_.edges[i], graph_) <= options_.max_chi2)) refuse(i);
    }
    return refused_ > before;
  }

  /// The other loops, by the optimized graph. Returns whether one is accepted.
  bool judgeOpen() {
    bool accepted = false;
    const GraphMarginals marginals(acceptedGraph(), result_.optimizer.edge_weights);
    for (const std::size_t i : loops_) {
      if (verdicts_[i] != Verdict::kOpen) continue;
      const std::optional<CycleCheck> cycle = checkCycle(graph_.edges[i], marginals);
      if (!cycle) continue;
      if (!(cycle->chi2 <= options_.max_chi2)) {
        refuse(i);
      } else if (isUnlikely(chance_.of(cycle->spread))) {
        verdicts_[i] = Verdict::kAccepted;
        accepted = true;
      }
    }
    return accepted;
  }

  PoseGraph& graph_;
  const RobustOptions options_;
  const OdometryChain chain_;
  const Chance chance_;
  std::vector<std::size_t> loops_;  // indices of edges
  std::vector<Verdict> verdicts_;   // of all edges
  std::size_t refused_ = 0, refused_before_ = 0;
  RobustResult result_;
};

}  // namespace

RobustResult optimizeRobustly(PoseGraph& graph, const RobustOptions& options) {
  RobustResult result;
  result.optimizer.problem = problemOf(graph);
  return result.optimizer.ok() ? RobustOptimization(graph, options).run() : result;
}

}  // namespace kestrel
