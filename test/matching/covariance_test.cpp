// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/covariance.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>
#include <string>

#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

/// A square room of half width 3 m with kBeams equally spaced beams on each wall.
struct Square {
  static constexpr double kHalf = 3.0, kVariance = 1e-4;
  static constexpr int kBeams = 60;

  /// Sum of 0.5 d² over the walls, which are infinitely long.
  static double cost(const Pose2& pose) {
    double sum = 0.0;
    for (int wall = 0; wall < 4; ++wall) {
      const Eigen::Vector2d normal(std::cos(0.5 * kPi * wall), std::sin(0.5 * kPi * wall));
      const Eigen::Vector2d tangent(-normal.y(), normal.x());
      for (int i = 0; i < kBeams; ++i) {
        const double at = kHalf * (2.0 * (i + 0.5) / kBeams - 1.0);
        const double distance = normal.dot(pose * (kHalf * normal + at * tangent)) - kHalf;
        sum += 0.5 * distance * distance;
      }
    }
    return sum;
  }

  /// Two walls constrain x and two constrain y. The lever arm of a beam for the yaw is its position
  /// along the wall, with mean square half² / 3 (1 - 1 / n²).
  static Eigen::Matrix3d hessian() {
    const double lever2 = kHalf * kHalf / 3.0 * (1.0 - 1.0 / (kBeams * kBeams));
    return Eigen::Vector3d(2.0 * kBeams, 2.0 * kBeams, 4.0 * kBeams * lever2).asDiagonal();
  }
};

TEST(Covariance, BothMethodsAreExactInASquareRoom) {
  const Eigen::Matrix3d truth = Square::kVariance * Square::hessian().inverse();
  const Eigen::Matrix3d hessian = hessianCovariance(Square::hessian(), Square::kVariance);
  EXPECT_TRUE(hessian.isApprox(truth, 1e-4)) << hessian;
  // The distance of the samples may differ from the result.
  for (const double spread : {0.5, 1.0, 9.0}) {
    const Eigen::Matrix3d sampled =
        sampledCovariance(Square::cost, Pose2(), spread * truth, Square::kVariance);
    EXPECT_TRUE(sampled.isApprox(truth, 1e-3)) << spread << '\n' << sampled;
  }
}

TEST(Covariance, TheSampledMethodMeasuresAQuarticCost) {
  // A quartic cost in x: flat in the middle, steep at its sides.
  const auto cost = [](const Pose2& p) {
    return 0.5 * (p.y * p.y + p.yaw * p.yaw) + 0.25 * std::pow(p.x, 4);
  };
  const Eigen::Matrix3d sampled =
      sampledCovariance(cost, Pose2(), Eigen::Matrix3d::Identity(), 1.0);
  // At 1 m the cost is 0.25, as that of a parabola with curvature 0.5. The curvature at 0 is 0.
  EXPECT_NEAR(sampled(0, 0), 2.0, 1e-9);
  EXPECT_NEAR(sampled(1, 1), 1.0, 1e-9);
  EXPECT_NEAR(sampled(0, 1), 0.0, 1e-9);
}

TEST(Covariance, TheSampledMethodIsFiniteForAFlatCost) {
  const Eigen::Matrix3d sampled = sampledCovariance([](const Pose2&) { return 0.0; }, Pose2(),
                                                    Eigen::Matrix3d::Identity(), 1.0);
  EXPECT_TRUE(sampled.isApprox(25.0 * Eigen::Matrix3d::Identity(), 1e-9)) << sampled;
}

TEST(Covariance, StretchedAlongOneDirectionOnly) {
  Eigen::Matrix3d covariance;
  covariance << 4.0, 1.0, 0.5, 1.0, 2.0, 0.25, 0.5, 0.25, 1.0;
  const Eigen::Matrix3d result = stretched(covariance, {0.0, 1.0}, 3.0);
  Eigen::Matrix3d expected;
  expected << 4.0, 3.0, 0.5, 3.0, 18.0, 0.75, 0.5, 0.75, 1.0;
  EXPECT_TRUE(result.isApprox(expected, 1e-12)) << result;
}

/// Matches scans of one place with independent noise of every beam. Computes the mean predicted
/// covariance and the covariance of the matched poses.
void matchNoisyScans(const std::string& method, Eigen::Matrix3d& predicted,
                     Eigen::Matrix3d& scatter) {
  constexpr int kRuns = 300, kMapScans = 40;
  constexpr float kNoise = 0.015F;
  std::mt19937 generator(7);
  std::normal_distribution<float> noise(0.0F, kNoise);
  const auto noisyScan = [&] {
    PlanarScan scan = room::scanFrom(Pose2());
    for (PlanarRay& ray : scan.rays) ray.end += Eigen::Vector2f(noise(generator), noise(generator));
    return scan;
  };
  Submap map{OccupancyGridConfig()};
  for (int i = 0; i < kMapScans; ++i) map.insert(noisyScan(), Pose2());
  MatcherConfig config;
  config.covariance = method;
  const auto matcher = makeMatcher(config);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  predicted.setZero();
  for (int i = 0; i < kRuns; ++i) {
    const Points points = hitsOf(noisyScan());
    const MatchResult found = matcher->match(map, {points, Pose2(), {Pose2()}, false, 1.0});
    const Eigen::Vector3d pose(found.pose.x, found.pose.y, found.pose.yaw);
    mean += pose / kRuns;
    second += pose * pose.transpose() / kRuns;
    predicted += found.covariance / kRuns;
  }
  scatter = second - mean * mean.transpose();
}

TEST(Covariance, MatchedPosesScatterAsPredicted) {
  // Since the errors of the beams are independent, the poses would scatter half as much as
  // predicted (kBeamCorrelation is 4), but the walls of the map have noise too.
  for (const std::string method : {"hessian", "sampled"}) {
    Eigen::Matrix3d predicted, scatter;
    matchNoisyScans(method, predicted, scatter);
    for (int i = 0; i < 3; ++i) {
      const double ratio = std::sqrt(predicted(i, i) / scatter(i, i));
      EXPECT_GT(ratio, 0.8) << method << ' ' << i;
      EXPECT_LT(ratio, 2.8) << method << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace kestrel
