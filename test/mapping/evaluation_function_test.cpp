// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/evaluation_function.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kestrel {
namespace {

MatchResult resultWith(double s1, double s2, double s3) {
  MatchResult match;
  match.stages = {StageEstimate{Pose2(), s1}, {Pose2(), s2}, {Pose2(), s3}};
  return match;
}

TEST(EvaluationFunction, IsTheInverseOfTheWeightedScoreIfAllResolutionsAgree) {
  // Weights 1/6, 2/6, 3/6: they increase with the resolution and sum to 1 [MAV SLAM 2013, eq. 5].
  const EvaluationConfig config;
  EXPECT_NEAR(evaluationFunction(resultWith(1, 1, 1), config), 1.0, 1e-12);
  EXPECT_NEAR(evaluationFunction(resultWith(0.6, 0.3, 0.2), config), 1.0 / 0.3, 1e-12);
  EXPECT_LT(evaluationFunction(resultWith(0.2, 0.3, 0.6), config),
            evaluationFunction(resultWith(0.6, 0.3, 0.2), config));
}

TEST(EvaluationFunction, PenalizesTheSpreadOfThePoses) {
  EvaluationConfig config;
  MatchResult match = resultWith(1, 1, 1);
  match.pose = Pose2(5, -3, kPi);
  // Yaws on both sides of pi, x 3 cm apart.
  match.stages[0].pose = Pose2(5.03, -3, kPi - 0.01);
  match.stages[1].pose = Pose2(5, -3, -kPi + 0.02);
  match.stages[2].pose = match.pose;
  const auto variance = [](double a, double b, double c) {
    const double mean = (a + b + c) / 3;
    return (a * a + b * b + c * c) / 3 - mean * mean;
  };
  const double expected =
      1.0 + config.penalty * (variance(0.03, 0, 0) / std::pow(config.sigma_m, 2) +
                              variance(-0.01, 0.02, 0) / std::pow(config.sigma_rad, 2));
  EXPECT_NEAR(evaluationFunction(match, config), expected, 1e-9);
}

TEST(EvaluationFunction, IsInfiniteIfNothingFits) {
  EXPECT_TRUE(std::isinf(evaluationFunction(MatchResult(), EvaluationConfig())));
}

}  // namespace
}  // namespace kestrel
