// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/evaluation_function.h"

#include <limits>

namespace kestrel {

double evaluationFunction(const MatchResult& match, const EvaluationConfig& config) {
  constexpr auto kStages = static_cast<double>(kMatchStages);
  constexpr double kWeightSum = kStages * (kStages + 1.0) / 2.0;
  double score = 0.0;
  Eigen::Array3d sum = Eigen::Array3d::Zero(), squares = Eigen::Array3d::Zero();
  for (std::size_t i = 0; i < kMatchStages; ++i) {
    const StageEstimate& stage = match.stages[i];
    score += static_cast<double>(i + 1) / kWeightSum * stage.score;  // eq. 5
    // Relative to the final pose: the variance is the same, and the yaw does not wrap around.
    const Eigen::Array3d x = offsetBetween(match.pose, stage.pose).array();
    sum += x;
    squares += x.square();
  }
  if (score <= 0.0) return std::numeric_limits<double>::infinity();
  const Eigen::Array3d variance = squares / kStages - (sum / kStages).square();
  const Eigen::Array3d unit(config.sigma_m, config.sigma_m, config.sigma_rad);
  return 1.0 / score + config.penalty * (variance / unit.square()).sum();
}

}  // namespace kestrel
