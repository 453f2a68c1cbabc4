// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "kestrel_slam/graph/odometry_chain.h"
#include "kestrel_slam/graph/pose_graph.h"

namespace kestrel {

/// A closed way through the graph, whose poses should compose to the identity.
struct CycleCheck {
  double chi2 = 0.0;  ///< with three degrees of freedom
  /// Square root of the determinant of the covariance of the error, m² rad. A false loop agrees by
  /// chance the more often, the larger this is.
  double spread = 0.0;
};

/// The cycle of two loops: along the one loop, along the odometry to the other loop, back along
/// that and along the odometry to the start [Mangelson 2018, eq. 8]. Odometry that both ways have
/// in common cancels out. Of the two cycles that two loops of one part have, the one with the
/// smaller spread is taken. Nothing if the odometry does not connect the loops.
std::optional<CycleCheck> checkCycle(const PoseEdge& a, const PoseEdge& b,
                                     const OdometryChain& chain);

/// The cycle of one loop and the odometry between its vertices. Nothing if these are in different
/// parts.
std::optional<CycleCheck> checkCycle(const PoseEdge& loop, const OdometryChain& chain);

struct ConsistencyOptions {
  double max_chi2 = 11.345;  ///< of a cycle; true loops exceed it in 1 % of the cases
  /// Of one search for the largest set, in operations on 64 bits: about 0.1 s.
  std::size_t max_work = 50'000'000;
};

/// Sets of loops that agree with each other; the numbers are those of ConsistentLoops::add().
struct Explanations {
  /// The largest set of loops that are consistent pair by pair.
  std::vector<std::size_t> first;
  /// The largest other one, of loops that each contradict at least half of the first set. If it is
  /// nearly as large as the first set, neither can be trusted.
  std::vector<std::size_t> second;
  bool exact = true;  ///< false: the work limit was reached, and larger sets may exist
};

/// Pairwise consistent measurement sets [Mangelson 2018]. False loops rarely agree with each other
/// and with the true ones, so the largest set of loops that agree holds true ones. The check is
/// only as sharp as the odometry between the loops is exact.
class ConsistentLoops {
 public:
  explicit ConsistentLoops(const ConsistencyOptions& options = {});
  ~ConsistentLoops();
  ConsistentLoops(ConsistentLoops&&) noexcept;
  ConsistentLoops& operator=(ConsistentLoops&&) noexcept;

  /// Compares `loop` with all loops so far, and returns its number: 0, 1, 2, ... Its vertices must
  /// be in the chain, and problemOf() must find nothing.
  std::size_t add(const PoseEdge& loop, const OdometryChain& chain);

  std::size_t size() const;

  /// Loops are consistent if their cycle has a small chi2. Two loops that the odometry does not
  /// connect say nothing about each other, and are not consistent.
  bool areConsistent(std::size_t a, std::size_t b) const;

  /// Of all loops. Where the odometry has several parts, these are the explanations for the pair of
  /// parts that gives the largest first set; ask for the loops of each pair with the other
  /// overload.
  Explanations explain() const;
  /// Of some loops, as those of one place or of one pair of parts.
  Explanations explain(const std::vector<std::size_t>& loops) const;

 private:
  struct Matrix;
  ConsistencyOptions options_;
  std::unique_ptr<Matrix> matrix_;
};

}  // namespace kestrel
