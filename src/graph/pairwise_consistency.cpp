// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/pairwise_consistency.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <numeric>

#include "kestrel_slam/geometry/pose_covariance.h"
#include "maximum_clique.h"

namespace kestrel {
namespace {

/// The odometry from one vertex to another of the same part, and the factor of its noise in the
/// error of a cycle.
struct Leg {
  std::size_t from, to;
  Eigen::Matrix3d factor;

  std::size_t begin() const { return std::min(from, to); }
  std::size_t end() const { return std::max(from, to); }
  /// With the sign of the direction.
  Eigen::Matrix3d signedFactor() const { return from < to ? factor : Eigen::Matrix3d(-factor); }
};

Eigen::Matrix3d transformed(const Eigen::Matrix3d& factor, const Eigen::Matrix3d& covariance) {
  return factor * covariance * factor.transpose();
}

/// The covariance that the odometry of both legs gives the cycle.
Eigen::Matrix3d odometryCovariance(const Leg& a, const Leg& b, const OdometryChain& chain) {
  const auto part = [&](const Eigen::Matrix3d& factor, std::size_t begin, std::size_t end) {
    return begin < end ? transformed(factor, chain.noiseBetween(begin, end))
                       : Eigen::Matrix3d(Eigen::Matrix3d::Zero());
  };
  const auto alone = [&](const Leg& leg, std::size_t common_begin, std::size_t common_end) {
    if (common_begin >= common_end) return part(leg.factor, leg.begin(), leg.end());
    return Eigen::Matrix3d(part(leg.factor, leg.begin(), common_begin) +
                           part(leg.factor, common_end, leg.end()));
  };
  std::size_t begin = std::max(a.begin(), b.begin()), end = std::min(a.end(), b.end());
  if (chain.partOf(a.from) != chain.partOf(b.from)) begin = end;
  const Eigen::Matrix3d common = part(a.signedFactor() + b.signedFactor(), begin, end);
  return alone(a, begin, end) + alone(b, begin, end) + common;
}

struct Cycle {
  Eigen::Vector3d error;
  Eigen::Matrix3d covariance;

  CycleCheck check() const {
    const Eigen::LLT<Eigen::Matrix3d> factor(covariance);
    const Eigen::Matrix3d root = factor.matrixL();
    return {error.dot(factor.solve(error)), root.diagonal().prod()};
  }
};

GaussianPose2 poseOf(const PoseEdge& loop) { return {loop.measured, loop.information.inverse()}; }

PoseEdge reversed(const PoseEdge& loop) {
  const GaussianPose2 pose = inverse(poseOf(loop));
  return {loop.to, loop.from, pose.mean, pose.covariance.inverse(), loop.kind};
}

/// The cycle a.from, a.to, b.to, b.from, a.from: along a, against b. Its error is in the tangent
/// space at the end; the noise of the odometry is linearized at an error of zero.
Cycle cycleOf(const PoseEdge& a, const PoseEdge& b, const OdometryChain& chain) {
  const auto odometry = [&](std::size_t from, std::size_t to) {
    return chain.pose(from).between(chain.pose(to));
  };
  const Pose2 back = b.measured.inverse() * odometry(b.from, a.from);  // b.to_T_a.from
  const Pose2 closed = a.measured * odometry(a.to, b.to) * back;
  const Eigen::Matrix3d J_a = a.measured.adjoint();  // a.to is at the inverse of a in the end
  const Eigen::Matrix3d J_b = odometry(a.from, b.from).adjoint() * b.measured.adjoint();
  const Leg there{a.to, b.to, J_a * chain.pose(a.to).inverse().adjoint()};
  const Leg home{b.from, a.from, chain.pose(a.from).inverse().adjoint()};
  return {closed.log(), transformed(J_a, a.information.inverse()) +
                            transformed(J_b, b.information.inverse()) +
                            odometryCovariance(there, home, chain)};
}

}  // namespace

std::optional<CycleCheck> checkCycle(const PoseEdge& a, const PoseEdge& b,
                                     const OdometryChain& chain) {
  const auto joined = [&](std::size_t v, std::size_t w) {
    return chain.partOf(v) == chain.partOf(w);
  };
  std::optional<CycleCheck> straight, turned;
  if (joined(a.from, b.from) && joined(a.to, b.to)) straight = cycleOf(a, b, chain).check();
  if (joined(a.from, b.to) && joined(a.to, b.from)) {
    turned = cycleOf(a, reversed(b), chain).check();
  }
  if (!straight || !turned) return straight ? straight : turned;
  return turned->spread < straight->spread ? turned : straight;
}

std::optional<CycleCheck> checkCycle(const PoseEdge& loop, const OdometryChain& chain) {
  if (chain.partOf(loop.from) != chain.partOf(loop.to)) return std::nullopt;
  const std::size_t begin = std::min(loop.from, loop.to), end = std::max(loop.from, loop.to);
  const PoseEdge forward = loop.from == begin ? loop : reversed(loop);
  const Pose2 odometry = chain.pose(begin).between(chain.pose(end));
  const Eigen::Matrix3d noise =
      transformed(chain.pose(end).inverse().adjoint(), chain.noiseBetween(begin, end));
  const Eigen::Vector3d error = forward.measured.between(odometry).log();
  return Cycle{error, noise + forward.information.inverse()}.check();
}

struct ConsistentLoops::Matrix {
  std::vector<PoseEdge> loops;
  std::vector<BitSet> rows;

  /// The largest consistent set of `loops`.
  Clique cliqueOf(const std::vector<std::size_t>& numbers, std::size_t max_work) const {
    std::vector<BitSet> neighbors(numbers.size(), BitSet(numbers.size()));
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      for (std::size_t k = 0; k < numbers.size(); ++k) {
        if (rows[numbers[i]].contains(numbers[k])) neighbors[i].insert(k);
      }
    }
    Clique clique = maximumClique(neighbors, max_work);
    for (std::size_t& member : clique.members) member = numbers[member];
    return clique;
  }

  bool contradicts(std::size_t loop, const std::vector<std::size_t>& set) const {
    const auto agreeing = std::count_if(set.begin(), set.end(), [&](std::size_t member) {
      return member == loop || rows[loop].contains(member);
    });
    return 2 * static_cast<std::size_t>(agreeing) <= set.size();
  }
};

ConsistentLoops::ConsistentLoops(const ConsistencyOptions& options)
    : options_(options), matrix_(std::make_unique<Matrix>()) {}
ConsistentLoops::~ConsistentLoops() = default;
ConsistentLoops::ConsistentLoops(ConsistentLoops&&) noexcept = default;
ConsistentLoops& ConsistentLoops::operator=(ConsistentLoops&&) noexcept = default;

std::size_t ConsistentLoops::size() const { return matrix_->loops.size(); }

bool ConsistentLoops::areConsistent(std::size_t a, std::size_t b) const {
  return a == b || matrix_->rows[a].contains(b);
}

std::size_t ConsistentLoops::add(const PoseEdge& loop, const OdometryChain& chain) {
  const std::size_t number = size();
  BitSet row(number + 1);
  for (std::size_t i = 0; i < number; ++i) {
    const std::optional<CycleCheck> cycle = checkCycle(loop, matrix_->loops[i], chain);
    if (!cycle || !(cycle->chi2 <= options_.max_chi2)) continue;
    row.insert(i);
    matrix_->rows[i].grow(number + 1);
    matrix_->rows[i].insert(number);
  }
  matrix_->rows.push_back(std::move(row));
  matrix_->loops.push_back(loop);
  return number;
}

Explanations ConsistentLoops::explain() const {
  std::vector<std::size_t> all(size());
  std::iota(all.begin(), all.end(), 0U);
  return explain(all);
}

Explanations ConsistentLoops::explain(const std::vector<std::size_t>& loops) const {
  const Clique first = matrix_->cliqueOf(loops, options_.max_work);
  std::vector<std::size_t> others;
  for (const std::size_t loop : loops) {
    if (matrix_->contradicts(loop, first.members)) others.push_back(loop);
  }
  const Clique second = matrix_->cliqueOf(others, options_.max_work);
  return {first.members, second.members, first.exact && second.exact};
}

}  // namespace kestrel
