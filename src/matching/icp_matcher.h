// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <vector>

#include "icp_reference.h"
#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/matching/icp.h"
#include "kestrel_slam/matching/matcher.h"

namespace kestrel {

/// Iterative closest points [Siew 2018; multi-robot ICP]: pair every hit with the nearest point of
/// the reference, reject the worst pairs, align, and repeat until convergence. Has three stages
/// with decreasing pair distances. If the fit is poor, the other initial guesses are tried, and
/// then rotated ones.
class IcpMatcher : public Matcher {
 public:
  explicit IcpMatcher(const MatcherConfig& config);
  MatchResult match(const Submap& map, const MatchRequest& request) const override;

 private:
  /// The data of one call of match.
  struct Task {
    const Submap& map;
    const MatchRequest& request;
    Points few;                ///< some of the points, for the coarse stages
    Eigen::AlignedBox2f area;  ///< hits outside this area get no partner
    /// All reference points within reach of the area.
    std::shared_ptr<const WallPoints> reference;
  };
  /// A local optimum and its score.
  struct Candidate {
    std::array<Pose2, kMatchStages> stages;
    Fit fit;
    int iterations = 0;
    bool converged = false;
    double penalized_score = -1.0;  ///< the score minus the penalty of the motion
  };

  Task taskOf(const Submap& map, const MatchRequest& request) const;
  Candidate refine(const Task& task, const Pose2& initial_guess, std::size_t first_stage = 0) const;
  void tryRotated(const Task& task, Candidate& best, int& iterations) const;
  void pairUp(const Task& task, const Points& points, const Pose2& pose, float reach_m,
              std::vector<IcpPair>& pairs) const;

  MatcherConfig config_;
  bool to_lines_;
  IcpReference reference_;
};

}  // namespace kestrel
