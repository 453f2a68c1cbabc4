// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/matching/matcher.h"

namespace kestrel {

/// Gauss-Newton on the distance to the walls, from the prediction; from other initial guesses where
/// that fit is poor; from an exhaustive search where those are poor as well.
class HybridMatcher : public Matcher {
 public:
  explicit HybridMatcher(const MatcherConfig& config) : config_(config) {}
  MatchResult match(const Submap& map, const MatchRequest& request) const override;

 private:
  /// A local optimum and how much it is worth.
  struct Candidate {
    Descent descent;
    Fit fit;
    std::array<Pose2, kMatchStages> stages;
    double penalized_score = -1.0;  ///< the score less what the motion costs
  };

  /// The local optimum near `initial_guess`, by the stages from `first_stage` on.
  Candidate refine(const Submap& map, const MatchRequest& request, const Pose2& initial_guess,
                   std::size_t first_stage = 0) const;
  void search(const Submap& map, const MatchRequest& request, MatchResult& result,
              Candidate& best) const;

  MatcherConfig config_;
};

/// Where to search for a scan that fits nowhere near, the nearest window first.
std::vector<SearchWindow> searchWindows(const MatcherConfig& config, const MatchRequest& request);

/// By how much `pose` has to be better than the local one to be taken.
double jumpMargin(const MatcherConfig& config, const MatchRequest& request, const Pose2& pose);

/// Points that are enough for coarse stages.
constexpr std::size_t kCoarsePoints = 150;

/// The score of a fit less what the motion to its pose costs: what candidates are compared by.
double preference(const MatchRequest& request, const Fit& fit, const Pose2& pose,
                  const CorrelativeConfig& config);

/// Fills the stages of a result: the poses and how well each fits at its own resolution, the last
/// at `scale_m` (that is `result.score`) and each coarser one at twice the scale of the next.
void fillStages(const Submap& map, const Points& points,
                const std::array<Pose2, kMatchStages>& poses, double scale_m, MatchResult& result);

/// A pose that was found, as it is judged: the normal equations at Cauchy scale `scale_m`, and the
/// fit.
struct Optimum {
  float scale_m;
  NormalEquations at_pose;
  Fit fit;
};

/// Fills score, known, covariance and degeneracy of a result, whose pose is known (paper 001,
/// IV-B).
void fillUncertainty(const Submap& map, const Points& points, const Optimum& optimum,
                     const MatcherConfig& config, MatchResult& result);

}  // namespace kestrel
