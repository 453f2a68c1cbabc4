// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/matching/match_result.h"

namespace kestrel {

/// Parameters of the penalized evaluation function (paper 000 eq. 4-5).
struct EvaluationConfig {
  bool enabled = true;
  /// T_V: a scan with f below this may enter the map. What it separates is drawn by
  /// `compare_matchers --evaluation`; below 1.5 it keeps out good scans and starves the map.
  double threshold = 1.75;
  double penalty = 0.25;    ///< the paper's positive penalty parameter
  double sigma_m = 0.05;    ///< unit in which the spread of the positions is measured
  double sigma_rad = 0.02;  ///< unit of the spread of the yaws
};

/// f of paper 000 eq. 4: small where the scan fits well and the resolutions agree on its pose.
///
///   f = 1 / Σ ω_i score(i) + penalty Σ_c (1/n Σ_i x̂_ic² - (1/n Σ_i x̂_ic)²) / σ_c²
///
/// with the stages i, coarse to fine, the components c of the pose, and weights ω_i that grow with
/// the resolution and sum to 1 (eq. 5). The paper counts matched cells and adds a variance in m² to
/// it; here the score is the share that fits and the variance is divided by σ_c², so that both
/// terms are numbers and a threshold holds for any laser. Infinite where nothing fits.
double evaluationFunction(const MatchResult& match, const EvaluationConfig& config);

}  // namespace kestrel
