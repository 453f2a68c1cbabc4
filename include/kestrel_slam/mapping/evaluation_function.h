// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/matching/match_result.h"

namespace kestrel {

/// Parameters of the penalized evaluation function [MAV SLAM 2013, eq. 4-5].
struct EvaluationConfig {
  bool enabled = true;
  /// T_V: a scan with f below this may be inserted into the map. `compare_matchers --evaluation`
  /// plots the separation. A threshold below 1.5 rejects good scans, and the map has gaps.
  double threshold = 1.75;
  double penalty = 0.25;    ///< penalty parameter of the paper, positive
  double sigma_m = 0.05;    ///< unit of the spread of the positions
  double sigma_rad = 0.02;  ///< unit of the spread of the yaws
};

/// f of [MAV SLAM 2013, eq. 4]: small if the scan fits well and all resolutions agree on its pose.
///
///   f = 1 / Σ ω_i score(i) + penalty Σ_c (1/n Σ_i x̂_ic² - (1/n Σ_i x̂_ic)²) / σ_c²
///
/// with the stages i (coarse to fine), the components c of the pose, and weights ω_i that increase
/// with the resolution and sum to 1 (eq. 5). The paper counts matched cells and adds a variance in
/// m². Here the score is the share of matched points and the variance is divided by σ_c². Both
/// terms are then dimensionless, and one threshold is valid for all lasers. Infinite if nothing
/// fits.
double evaluationFunction(const MatchResult& match, const EvaluationConfig& config);

}  // namespace kestrel
