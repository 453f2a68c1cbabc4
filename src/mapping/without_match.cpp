// SPDX-License-Identifier: BSD-3-Clause
// What the mapper does with a scan that fits nowhere near the prediction.
#include "kestrel_slam/mapping/odometry_slip.h"
#include "kestrel_slam/matching/fit.h"
#include "mapper_state.h"

namespace kestrel {

/// The odometry may be wrong if the scan does not fit, or hardly, near it. What is found elsewhere
/// fits in one way only, and that was searched for more widely than for an ordinary match: so the
/// state is ok.
void Mapper::State::matchElsewhere(const MatchRequest& request, MapperResult& result) {
  constexpr double kHardlyFits = 0.5;
  if (result.state != MatchState::kLost && result.match.score >= kHardlyFits) return;
  const std::optional<MatchResult> found =
      matchAfterSlip(map.current(), request, motion.pose(), result.match, config.matcher);
  if (!found) return;
  result.match = *found;
  result.match.searched = true;
  result.evaluation = evaluationFunction(result.match, config.evaluation);
  result.state = MatchState::kOk;
}

/// Whether the prediction is good enough to go on without a match: by odometry always, otherwise as
/// long as the near search around the prediction finds the vehicle again.
bool Mapper::State::isCarried(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                              const PredictionError& error) const {
  return !motion.isPlaced() &&
         (motion.predictionSourceOf(scan, odom_T_base) == PredictionSource::kOdometry ||
          !motion.isWide(error));
}

/// The scan shows nothing to match: the motion goes on as predicted.
void Mapper::State::carry(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                          const PredictionError& error, MapperResult& result) {
  const bool lost = !isCarried(scan, odom_T_base, error);
  motion.carry(scan, odom_T_base);
  motion.learnOdometry(motion.pose(), odom_T_base, false);
  uncertainty.carry(motion.pose(), error);
  result.match.pose = motion.pose();
  result.carried = true;
  result.state = lost ? MatchState::kLost : MatchState::kDegraded;
}

/// The scan fits nowhere near the prediction, for example because most of it is in new space: the
/// motion goes on as predicted. What of the scan is in known space decides on the insertion.
void Mapper::State::carryUnmatched(const Points& points, const PlanarScan& scan,
                                   const std::optional<Pose2>& odom_T_base,
                                   const PredictionError& error, MapperResult& result) {
  carry(scan, odom_T_base, error, result);
  fillFit(points, result);
}

/// The fit to the map at a pose that was not found in it.
void Mapper::State::fillFit(const Points& points, MapperResult& result) const {
  result.match.pose = motion.pose();
  const Fit fit = fitOf(map.current(), points, motion.pose(), config.matcher.score_scale_m);
  result.match.score = fit.score;
  result.match.known = fit.known;
  for (StageEstimate& stage : result.match.stages) stage = {motion.pose(), fit.score};
  result.evaluation = evaluationFunction(result.match, config.evaluation);
}

}  // namespace kestrel
