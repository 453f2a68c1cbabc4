// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/mapping/motion_model.h"
#include "kestrel_slam/matching/match_result.h"
#include "kestrel_slam/matching/weak_motion.h"

namespace kestrel {

/// Whether the motion prediction takes part along the weakest direction: always if it is
/// unobservable. Without a motion sensor also if few beams show it, because they may be wrong.
bool isWeak(const MatchResult& match, PredictionSource source);

/// Whether the match shows nothing along the weakest direction. Without a motion sensor the little
/// that it shows is used: otherwise a scan may be inserted with an error of centimeters, and loops
/// of whole buildings do not close.
bool isUnobservable(const MatchResult& match, PredictionSource source);

/// The beams that count along the weakest direction.
Beams beamsOf(PredictionSource source);

WeakMotion weakMotionOf(const MatchResult& match);

/// Checks whether the scan shows clearly that the vehicle is not where it was predicted along the
/// weakest direction, `away_m` from the match, with the standard deviation `sigma_m`. A part of a
/// wall that looks like another one can move the match by decimeters, and the scan fits there.
void checkAlong(const Submap& map, const Points& points, double away_m, double sigma_m,
                MatchResult& match);

/// Replaces the match along the weakest direction by the motion prediction. Returns the distance
/// from there to the match, m.
double keepPredictionAlong(const Pose2& motion_prediction, MatchResult& match);

/// The match, `matched_m` from the prediction, where `fit` does not contradict it: the match is
/// more accurate. Otherwise `fit`.
AlongFit combined(const AlongFit& fit, double matched_m);

/// Corrects the predicted position along the weakest direction by the few beams that show it.
/// `variance`: of the prediction, m².
void correctAlong(const AlongFit& fit, double variance, double seconds, MatchResult& match);

}  // namespace kestrel
