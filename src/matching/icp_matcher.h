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

/// Iterative closest points (papers 003 and 004): pair every hit with the nearest point of the
/// reference, reject the worst pairs, align, and again until nothing moves. In three stages, each
/// of which looks for partners less far; from the other initial guesses where that fits poorly, and
/// from turned ones where those do.
class IcpMatcher : public Matcher {
 public:
  explicit IcpMatcher(const MatcherConfig& config);
  MatchResult match(const Submap& map, const MatchRequest& request) const override;

 private:
  /// What one call of match works on.
  struct Task {
    const Submap& map;
    const MatchRequest& request;
    Points few;                ///< of the request's points, for the coarse stages
    Eigen::AlignedBox2f area;  ///< where hits look for partners
    std::shared_ptr<const NearestPoints> reference;  ///< all points within reach of the area
  };
  /// A local optimum and how much it is worth.
  struct Candidate {
    std::array<Pose2, kMatchStages> stages;
    Fit fit;
    int iterations = 0;
    bool converged = false;
    double penalized_score = -1.0;  ///< the score less what the motion costs
  };

  Task taskOf(const Submap& map, const MatchRequest& request) const;
  Candidate refine(const Task& task, const Pose2& initial_guess, std::size_t first_stage = 0) const;
  void tryTurned(const Task& task, Candidate& best, int& iterations) const;
  void pairUp(const Task& task, const Points& points, const Pose2& pose, float reach_m,
              std::vector<IcpPair>& pairs) const;

  MatcherConfig config_;
  bool to_lines_;
  IcpReference reference_;
};

}  // namespace kestrel
