// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/matching/weak_motion.h"
#include "kestrel_slam/matching/work_budget.h"

namespace kestrel {

/// Gauss-Newton on the distance to the walls, starting at the prediction. If the fit is poor, the
/// other initial guesses are tried, and then the search of a window.
class HybridMatcher : public Matcher {
 public:
  explicit HybridMatcher(const MatcherConfig& config) : config_(config) {}
  MatchResult match(const Submap& map, const MatchRequest& request) const override;

  /// The local optimum near `guess`, without a search and without a penalty of the motion.
  MatchResult refined(const Submap& map, const Points& points, const Pose2& guess) const;

 private:
  /// A local optimum and its score.
  struct Candidate {
    Descent descent;
    Fit fit;
    std::array<Pose2, kMatchStages> stages;
    /// The score minus the penalty of the motion, if points in unknown space count as misses.
    double all_points_score = -1.0;
    /// By what it is compared with the optima from other guesses: the same where the pose is near
    /// them, so that none is better because more of the scan is in unknown space. Otherwise such
    /// points do not count: a vehicle may have come to a place that is mostly new.
    double worth = -1.0;
    bool jumped = false;  ///< the descent began outside of the basin of convergence
  };

  /// Which hits take part in a descent: those of known walls if it begins near the pose (see
  /// hitsOfKnownWalls), otherwise all.
  enum class Hits { kAll, kOfKnownWalls };

  /// The local optimum near `initial_guess`, with the stages from `first_stage` on.
  Candidate refine(const Submap& map, const MatchRequest& request, const Pose2& initial_guess,
                   Hits hits, std::size_t first_stage = 0) const;
  void fill(const Submap& map, const MatchRequest& request, const Candidate& best,
            MatchResult& result) const;
  class Optima;
  void search(const Submap& map, const MatchRequest& request, Optima& optima, MatchResult& result,
              Candidate& best) const;
  std::vector<Pose2> mostLikely(const Submap& map, const MatchRequest& request,
                                const std::vector<Pose2>& hypotheses, WorkBudget& budget) const;

  MatcherConfig config_;
};

/// The center of the search windows: the last pose, with the predicted yaw if that is accurate.
Pose2 searchCenter(const MatchRequest& request);

/// Whether the pose is farther from the prediction than the vehicle can have moved.
bool isJump(const MatchRequest& request, const Pose2& pose);

/// The search windows for a scan without a good fit near the initial guesses, smallest first.
std::vector<SearchWindow> searchWindows(const MatcherConfig& config, const MatchRequest& request);

/// Minimum increase of the penalized score that is needed to accept `pose`.
double jumpMargin(const MatcherConfig& config, const MatchRequest& request, const Pose2& pose);

/// Cauchy scales of the stages, m. A wide scale has a large basin of convergence; the last one only
/// uses points close to a wall. With 0.1 m as the last scale the error of the recordings is 10 %
/// larger, with 0.2 m 30 %.
constexpr std::array<float, kMatchStages> kStageScales = {0.3F, 0.12F, 0.05F};
/// The early stages only have to reach the basin of convergence of the next stage.
constexpr double kCoarseStepM = 0.01, kCoarseStepRad = 0.005;
/// Information of the prior at the initial guess, relative to that of the points across a wall. It
/// only has an effect in unobservable directions.
constexpr float kPriorWeight = 1e-3F;
/// Number of points for the coarse stages.
constexpr std::size_t kCoarsePoints = 150;
/// Work for the searches of one scan.
constexpr std::int64_t kSearchWork = 10'000'000;
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
  Beams shown_by = Beams::kCertain;  ///< the beams that show the weakest direction
};

/// Fills score, known, covariance and degeneracy of a result with a given pose [Kohlbrecher 2011,
/// sec. IV-B].
void fillUncertainty(const Submap& map, const Points& points, const Optimum& optimum,
                     const MatcherConfig& config, MatchResult& result);

}  // namespace kestrel
