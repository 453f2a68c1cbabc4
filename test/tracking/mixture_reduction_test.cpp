// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/mixture_reduction.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "component_at.h"
#include "kestrel_slam/geometry/random.h"

namespace kestrel {
namespace {

using Vector4 = Eigen::Vector4d;
using Matrix4 = Eigen::Matrix4d;
using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

constexpr auto anyPair = [](const auto&, const auto&) { return true; };

/// A target that stands after one step of its motion model: it has no turn rate.
PhdComponent<5> standingAt(double x, double y, double weight) {
  PhdComponent<5> start;
  start.mean << x, y, 1.0, 0.0, 0.3;
  start.covariance = 0.04 * Matrix5::Identity();
  start.weight = weight;
  standing<5, 2>(0.1, 0.5)(0.1, start.mean, start.covariance);
  return start;
}

TEST(MixtureReduction, MergingKeepsWeightMeanAndCovariance) {
  Random random(6);
  std::vector<PhdComponent<4>> mixture;
  double weight = 0.0;
  Vector4 mean = Vector4::Zero();
  for (int i = 0; i < 5; ++i) {
    mixture.push_back(componentAt(0.1 * random.gaussian(), 0.0, 0.0, 0.0, random.uniform()));
    weight += mixture.back().weight;
    mean += mixture.back().weight * mixture.back().mean;
  }
  mean /= weight;
  Matrix4 covariance = Matrix4::Zero();
  for (const auto& c : mixture) {
    covariance +=
        c.weight / weight * (c.covariance + (c.mean - mean) * (c.mean - mean).transpose());
  }
  const auto reduced = reduceMixture(mixture, PhdLimits(), anyPair);
  ASSERT_EQ(reduced.size(), 1U);
  EXPECT_NEAR(reduced[0].weight, weight, 1e-12);
  EXPECT_LT((reduced[0].mean - mean).norm(), 1e-12);
  EXPECT_LT((reduced[0].covariance - covariance).norm(), 1e-12);
}

TEST(MixtureReduction, PrunesMergesAndCaps) {
  PhdLimits limits;
  limits.max_components = 2;
  // 0.39 m are less than two standard deviations of 0.2 m, 0.41 m are more.
  std::vector<PhdComponent<4>> mixture{componentAt(0.0, 0, 0, 0, 0.5),
                                       componentAt(0.39, 0, 0, 0, 0.1),
                                       componentAt(0.0, 0.41, 0, 0, 0.3),
                                       componentAt(9, 0, 0, 0, 1e-6), componentAt(7, 0, 0, 0, 0.2)};
  const auto reduced = reduceMixture(mixture, limits, anyPair);
  ASSERT_EQ(reduced.size(), 2U);
  EXPECT_NEAR(reduced[0].weight, 0.6, 1e-12);
  EXPECT_NEAR(reduced[1].weight, 0.3, 1e-12);
}

TEST(MixtureReduction, OnlyComponentsOfOneMotionModelAreMerged) {
  std::vector<PhdComponent<4>> mixture{componentAt(0, 0, 0, 0, 0.5), componentAt(0, 0, 0, 0, 0.4),
                                       componentAt(0, 0, 0, 0, 0.2), componentAt(0, 0, 0, 0, 0.1)};
  mixture[1].mode = mixture[3].mode = 2;
  const auto reduced = reduceMixture(mixture, PhdLimits(), anyPair);
  ASSERT_EQ(reduced.size(), 2U);
  EXPECT_NEAR(reduced[0].weight, 0.7, 1e-12);
  EXPECT_EQ(reduced[0].mode, 0);
  EXPECT_NEAR(reduced[1].weight, 0.5, 1e-12);
  EXPECT_EQ(reduced[1].mode, 2);
}

TEST(MixtureReduction, WhatStandsElsewhereIsNotMerged) {
  // 0.2 m of sigma: 1 m is far, 0.1 m is near.
  const auto reduced = reduceMixture<5>(
      {standingAt(0.0, 0.0, 0.9), standingAt(1.0, 0.0, 0.8), standingAt(0.0, 0.1, 0.1)},
      PhdLimits(), anyPair);
  ASSERT_EQ(reduced.size(), 2U);
  EXPECT_NEAR(reduced[0].weight, 1.0, 1e-12);
  EXPECT_NEAR(reduced[0].mean.x(), 0.0, 1e-12);
  EXPECT_NEAR(reduced[1].weight, 0.8, 1e-12);
  EXPECT_NEAR(reduced[1].mean.x(), 1.0, 1e-12);
}

TEST(MixtureReduction, WhatTurnsIsNotMergedIntoWhatCannotTurn) {
  PhdComponent<5> turns = standingAt(0.0, 0.0, 0.9);
  turns.mean(4) = 1e-3;
  turns.covariance(4, 4) = 0.1;
  EXPECT_EQ(reduceMixture<5>({turns, standingAt(0.0, 0.0, 0.1)}, PhdLimits(), anyPair).size(), 2U);
}

TEST(GaussianDistance, IsThatOfTheInverse) {
  Random random(7);
  for (int i = 0; i < 50; ++i) {
    const Matrix5 root = Matrix5::NullaryExpr([&] { return random.gaussian(); });
    const Vector5 a = Vector5::NullaryExpr([&] { return random.gaussian(); });
    const Vector5 b = Vector5::NullaryExpr([&] { return random.gaussian(); });
    const Matrix5 covariance = root * root.transpose() + 0.01 * Matrix5::Identity();
    const double expected = (a - b).dot(covariance.inverse() * (a - b));
    EXPECT_NEAR(GaussianDistance<5>(covariance).squared(a, b), expected, 1e-8 * expected);
  }
}

TEST(GaussianDistance, OfAFlatGaussianIsThatInItsPlane) {
  // A plane through the five directions. Beside it, the distance is infinite.
  Random random(8);
  for (int i = 0; i < 50; ++i) {
    const auto gaussian = [&] { return random.gaussian(); };
    const Eigen::Matrix<double, 5, 3> span = Eigen::Matrix<double, 5, 3>::NullaryExpr(gaussian);
    const Eigen::Vector3d within = Eigen::Vector3d::NullaryExpr(gaussian);
    const Vector5 b = Vector5::NullaryExpr(gaussian), beside = Vector5::NullaryExpr(gaussian);
    const GaussianDistance<5> distance(span * span.transpose());
    EXPECT_NEAR(distance.squared(b + span * within, b), within.squaredNorm(), 1e-6);
    EXPECT_TRUE(std::isinf(distance.squared(b + beside, b)));
  }
}

TEST(GaussianDistance, OfAPointIsZeroOrInfinite) {
  const GaussianDistance<4> distance(Matrix4::Zero());
  const Vector4 place(1.0, 2.0, 3.0, 4.0);
  EXPECT_EQ(distance.squared(place, place), 0.0);
  EXPECT_TRUE(std::isinf(distance.squared(place, place + Vector4(0.0, 1e-3, 0.0, 0.0))));
}

}  // namespace
}  // namespace kestrel
