// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/merging/joint_map.h"

namespace kestrel {

/// The poses of all keyframes with the maps of two vehicles joined by loops between them.
std::vector<PoseVertex> joinedByLoops(const JointMap& joint, std::size_t a, std::size_t b,
                                      const std::vector<Loop>& loops,
                                      const std::vector<Loop>& refined = {});

/// A loop that says where the map of b was said to be in that of a.
Loop givenLoop(const JointMap& joint, std::size_t a, std::size_t b, const Pose2& a_T_b);

/// The graph of all vehicles.
class JointSolution {
 public:
  explicit JointSolution(const JointMap& joint);
  /// The graph of two vehicles. All others stay.
  JointSolution(const JointMap& joint, std::size_t a, std::size_t b);

  /// Joins two vehicles. `pair`: its number. `refined`: loops that may be left out one by one.
  void join(std::size_t pair, std::size_t a, std::size_t b, const std::vector<Loop>& loops,
            const std::vector<Loop>& refined);
  void solve();

  /// The pairs whose loops do not fit into the solution, the worst one first.
  std::vector<std::size_t> contradicted() const;
  const PoseGraph& graph() const { return graph_; }
  const std::vector<std::size_t>& groups() const { return groups_; }
  std::size_t loopsBetween() const { return edges_.size(); }

 private:
  /// An edge between two vehicles.
  struct Between {
    std::size_t edge, pair;
    bool refined;
  };

  void move(std::size_t group, std::size_t onto, const Pose2& onto_T_group);

  const JointMap& joint_;
  PoseGraph graph_;
  std::vector<std::size_t> groups_;  ///< for each vehicle, the first one of its group
  std::vector<Between> edges_;
  std::vector<double> weights_;  ///< of the edges, after solve()
};

}  // namespace kestrel
