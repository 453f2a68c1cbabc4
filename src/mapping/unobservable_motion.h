// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/mapping/motion_model.h"
#include "kestrel_slam/matching/match_result.h"
#include "kestrel_slam/matching/weak_motion.h"

namespace kestrel {

/// Whether the motion prediction is better than the match along the degenerate direction. Without a
/// motion sensor the little that the scan shows is used: otherwise a scan may be inserted with an
/// error of centimeters, and loops of whole buildings do not close.
bool isUnobservable(const MatchResult& match, PredictionSource source);

WeakMotion weakMotionOf(const MatchResult& match);

/// Replaces the match along the unobservable direction by the motion prediction. There the match
/// only shows the discretization error of the cells.
void keepPredictionAlong(const Pose2& motion_prediction, MatchResult& match);

/// Corrects the predicted position along the unobservable direction by the few beams that show it.
/// `variance`: of the prediction, m².
void correctAlong(const AlongFit& fit, double variance, double seconds, MatchResult& match);

}  // namespace kestrel
