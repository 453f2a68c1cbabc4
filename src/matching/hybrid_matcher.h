// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/matching/matcher.h"

namespace kestrel {

/// Gauss-Newton on the distance to the walls, starting at the prediction. If the fit is poor, the
/// other initial guesses are tried, and then the exhaustive search.
class HybridMatcher : public Matcher {
 public:
  explicit HybridMatcher(const MatcherConfig& config) : config_(config) {}
  MatchResult match(const Submap& map, const MatchRequest& request) const override;

 private:
  /// A local optimum and its score.
  struct Candidate {
    Descent descent;
    Fit fit;
    std::array<Pose2, kMatchStages> stages;
    double penalized_score = -1.0;  ///< the score minus the penalty of the motion
    bool jumped = false;            ///< the descent began outside of the basin of convergence
  };

  /// The local optimum near `initial_guess`, with the stages from `first_stage` on.
  Candidate refine(const Submap& map, const MatchRequest& request, const Pose2& initial_guess,
                   std::size_t first_stage = 0) const;
  void search(const Submap& map, const MatchRequest& request, MatchResult& result,
              Candidate& best) const;

  MatcherConfig config_;
};

/// The search windows for a scan without a good fit near the initial guesses, smallest first.
std::vector<SearchWindow> searchWindows(const MatcherConfig& config, const MatchRequest& request);

/// Minimum increase of the penalized score that is needed to accept `pose`.
double jumpMargin(const MatcherConfig& config, const MatchRequest& request, const Pose2& pose);

/// Number of points for the coarse stages.
constexpr std::size_t kCoarsePoints = 150;
/// Number of points for the search of a lost vehicle in a wide window.
constexpr std::size_t kLostPoints = 200;

/// The penalty of a motion for this request: smaller if nothing was seen for some time.
CorrelativeConfig preferencesFor(const MatchRequest& request, const CorrelativeConfig& config);

/// The score of a fit minus the penalty of the motion to its pose. Candidates are compared by it.
double penalizedScore(const MatchRequest& request, const Fit& fit, const Pose2& pose,
                      const CorrelativeConfig& config);

/// Fills the stages of a result: the poses, and the score of each at its own resolution. The scale
/// of the last stage is `scale_m` (its score is `result.score`); that of each coarser stage is
/// twice that of the next.
void fillStages(const Submap& map, const Points& points,
                const std::array<Pose2, kMatchStages>& poses, double scale_m, MatchResult& result);

/// An optimum: the normal equations with Cauchy scale `scale_m`, and the fit.
struct Optimum {
  float scale_m;
  NormalEquations at_pose;
  Fit fit;
};

/// Fills score, known, covariance and degeneracy of a result with a given pose [Kohlbrecher 2011,
/// sec. IV-B].
void fillUncertainty(const Submap& map, const Points& points, const Optimum& optimum,
                     const MatcherConfig& config, MatchResult& result);

}  // namespace kestrel
