// SPDX-License-Identifier: BSD-3-Clause
// What the mapper does with a scan that fits nowhere near the prediction.
#include "kestrel_slam/mapping/odometry_slip.h"
#include "kestrel_slam/matching/ambiguity.h"
#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/matching/place_match.h"
#include "mapper_state.h"

namespace kestrel {

/// How the odometry may be wrong, by what was matched near it. The wheels may have slipped if the
/// scan hardly fits. An odometry that may not know the direction is believed only where the scan
/// fits well, and one that does not know it is compared with all other places.
SlipKind Mapper::State::slipKindOf(const MapperResult& result) const {
  constexpr double kHardlyFits = 0.5;
  const bool lost = result.state == MatchState::kLost;
  const double score = result.match.score;
  return {lost || score < kHardlyFits || motion.isUnsigned(),
          motion.isUnsigned() ||
              (motion.mayBeReversed() && (lost || score < config.matcher.search_score))};
}

/// What is found elsewhere fits in one way only, and that was searched for more widely than for an
/// ordinary match: so the state is ok if it fits well.
void Mapper::State::matchElsewhere(const MatchRequest& request, MapperResult& result) {
  const SlipKind kind = slipKindOf(result);
  if (!kind.any && !kind.reverse) return;
  const FitAfterSlip found =
      matchAfterSlip(map.current(), request, motion.pose(), result.match, config.matcher, kind);
  result.reversed = found.match && found.is_reverse;
  if (found.match) {
    const bool is_better = found.match->score * found.match->known >=
                           result.match.score * result.match.known + kClearlyBetter;
    const bool is_same = isSamePlace(*found.match, result.match.pose);
    if (result.state != MatchState::kLost && is_same && !is_better) return;
    result.match = *found.match;
    result.match.searched = true;
    result.evaluation = evaluationFunction(result.match, config.evaluation);
    result.state =
        result.match.score >= config.matcher.search_score ? MatchState::kOk : MatchState::kDegraded;
  } else if (found.ambiguous && motion.isUnsigned() && result.state == MatchState::kOk) {
    result.match.ambiguous = true;
    result.state = MatchState::kDegraded;
  }
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
  motion.learnOdometry(motion.pose(), odom_T_base, MatchWorth::kNone);
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
