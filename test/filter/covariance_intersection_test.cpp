// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/filter/covariance_intersection.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace kestrel {
namespace {

Eigen::Matrix3d rotated(const Eigen::Vector3d& variances, const Eigen::Vector3d& axis) {
  const Eigen::Matrix3d r = Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix();
  return r * variances.asDiagonal() * r.transpose();
}

TEST(CovarianceIntersection, OfEqualCovariancesIsTheSameCovariance) {
  const Eigen::Matrix3d c = rotated({1.0, 4.0, 9.0}, {0.1, 0.2, 0.3});
  const Intersection<3> fused = intersect<3>(c, c);
  EXPECT_LT((fused.covariance - c).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(CovarianceIntersection, SelectsTheBetterEstimateIfItIsBetterInAllDirections) {
  const Eigen::Matrix3d c = rotated({1.0, 4.0, 9.0}, {0.1, 0.2, 0.3});
  EXPECT_EQ(intersect<3>(c, 4.0 * c).weight, 1.0);
  const Intersection<3> measured = intersect<3>(4.0 * c, c);
  EXPECT_EQ(measured.weight, 0.0);
  EXPECT_LT((measured.covariance - c).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((measured.gain - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-12);
}

/// The result follows the definition, and no other weight is better.
TEST(CovarianceIntersection, MatchesTheDefinitionWithTheBestWeight) {
  const Eigen::Matrix3d a = rotated({1.0, 0.1, 2.0}, {0.3, -0.2, 0.5});
  const Eigen::Matrix3d b = rotated({0.2, 1.5, 1.0}, {-0.4, 0.6, 0.1});
  const Intersection<3> fused = intersect<3>(a, b);
  const auto at = [&](double w) {
    return Eigen::Matrix3d((w * a.inverse() + (1.0 - w) * b.inverse()).inverse());
  };
  EXPECT_GT(fused.weight, 0.0);
  EXPECT_LT(fused.weight, 1.0);
  EXPECT_LT((fused.covariance - at(fused.weight)).cwiseAbs().maxCoeff(), 1e-9);
  const Eigen::Matrix3d gain = (1.0 - fused.weight) * fused.covariance * b.inverse();
  EXPECT_LT((fused.gain - gain).cwiseAbs().maxCoeff(), 1e-9);
  for (double w = 0.0; w <= 1.0; w += 0.01) {
    EXPECT_GE(at(w).determinant(), fused.covariance.determinant() * (1.0 - 1e-9)) << w;
  }
}

/// For any correlation of the two errors the true covariance is not larger than the result [Julier
/// 1997].
TEST(CovarianceIntersection, IsNotOverconfidentForAnyCorrelation) {
  const Eigen::Matrix3d a = rotated({1.0, 0.1, 2.0}, {0.3, -0.2, 0.5});
  const Eigen::Matrix3d b = rotated({0.2, 1.5, 1.0}, {-0.4, 0.6, 0.1});
  const Intersection<3> fused = intersect<3>(a, b);
  const Eigen::Matrix3d root_a = a.llt().matrixL(), root_b = b.llt().matrixL();
  const Eigen::Matrix3d rest = Eigen::Matrix3d::Identity() - fused.gain;
  for (const double correlation : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    const Eigen::Matrix3d cross = correlation * root_a * root_b.transpose();
    const Eigen::Matrix3d mixed = rest * cross * fused.gain.transpose();
    const Eigen::Matrix3d truth = rest * a * rest.transpose() +
                                  fused.gain * b * fused.gain.transpose() + mixed +
                                  mixed.transpose();
    const Eigen::Matrix3d margin = fused.covariance - truth;
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(margin).eigenvalues()(0), -1e-9)
        << correlation;
  }
}

}  // namespace
}  // namespace kestrel
