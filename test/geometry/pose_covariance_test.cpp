// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/geometry/pose_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>
#include <vector>

#include "kestrel_slam/geometry/random.h"

namespace kestrel {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A full covariance with standard deviations of about `sigma`.
template <int Size>
Eigen::Matrix<double, Size, Size> randomCovariance(Random& random, double sigma) {
  Eigen::Matrix<double, Size, Size> root;
  for (int i = 0; i < root.size(); ++i) root(i) = random.uniform(-sigma, sigma);
  return root * root.transpose();
}

GaussianPose2 randomPose(Random& random, double sigma) {
  const double x = random.uniform(-20.0, 20.0), y = random.uniform(-20.0, 20.0);
  return {Pose2(x, y, random.uniform(-kPi, kPi)), randomCovariance<3>(random, sigma)};
}

Vector6d gaussian(Random& random) {
  Vector6d result;
  for (int i = 0; i < result.size(); ++i) result(i) = random.gaussian();
  return result;
}

/// A function of two poses with an error each.
using Combined = std::function<Pose2(const Eigen::Vector3d&, const Eigen::Vector3d&)>;

/// The derivative of the error of `f` by both errors, by central differences.
Eigen::Matrix<double, 3, 6> differences(const Combined& f) {
  constexpr double kStep = 1e-5;
  const Pose2 undo = f(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()).inverse();
  Eigen::Matrix<double, 3, 6> result;
  for (int i = 0; i < 6; ++i) {
    const Vector6d step = kStep * Vector6d::Unit(i);
    const Eigen::Vector3d above = (undo * f(step.head<3>(), step.tail<3>())).log();
    const Eigen::Vector3d below = (undo * f(-step.head<3>(), -step.tail<3>())).log();
    result.col(i) = (above - below) / (2.0 * kStep);
  }
  return result;
}

void expectNear(const Eigen::Matrix3d& found, const Eigen::Matrix3d& expected, double tolerance) {
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), tolerance * expected.cwiseAbs().maxCoeff())
      << "found\n"
      << found << "\nexpected\n"
      << expected;
}

void expectCovariance(const Eigen::Matrix3d& c) {
  const double size = c.cwiseAbs().maxCoeff();
  EXPECT_LT((c - c.transpose()).cwiseAbs().maxCoeff(), 1e-14 * size);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(c).eigenvalues()(0), -1e-14 * size);
}

Matrix6d blockDiagonal(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  Matrix6d result = Matrix6d::Zero();
  result.topLeftCorner<3, 3>() = a;
  result.bottomRightCorner<3, 3>() = b;
  return result;
}

/// What is computed in closed form, and by which function of the erroneous poses.
struct Case {
  const char* name;
  GaussianPose2 found;
  Combined f;
};

std::vector<Case> casesOf(const GaussianPose2& a, const GaussianPose2& b) {
  const auto erroneous = [](const GaussianPose2& pose, const Eigen::Vector3d& t) {
    return pose.mean * Pose2::exp(t);
  };
  using Vector = Eigen::Vector3d;
  return {
      {"inverse", inverse(a),
       [=](const Vector& t, const Vector&) { return erroneous(a, t).inverse(); }},
      {"compose", compose(a, b),
       [=](const Vector& t, const Vector& u) { return erroneous(a, t) * erroneous(b, u); }},
      {"between", between(a, b),
       [=](const Vector& t, const Vector& u) {
         return erroneous(a, t).inverse() * erroneous(b, u);
       }},
      {"transported", transported(a, b.mean),
       [=](const Vector& t, const Vector&) { return erroneous(a, t) * b.mean; }},
  };
}

TEST(PoseCovariance, IsThatOfTheExactLinearization) {
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const GaussianPose2 a = randomPose(random, 0.1), b = randomPose(random, 0.1);
    const Matrix6d joint = blockDiagonal(a.covariance, b.covariance);
    for (const Case& c : casesOf(a, b)) {
      SCOPED_TRACE(c.name);
      const auto jacobian = differences(c.f);
      expectNear(c.found.covariance, jacobian * joint * jacobian.transpose(), 1e-8);
      const Pose2 mean = c.f(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
      EXPECT_LT(offsetBetween(mean, c.found.mean).norm(), 1e-12);
      expectCovariance(c.found.covariance);
    }
  }
}

/// Errors that are drawn, not linearized: their scatter in units of the covariance is that of
/// independent numbers.
TEST(PoseCovariance, IsThatOfDrawnErrors) {
  constexpr int kDraws = 20000;
  constexpr double kTolerance = 0.05;  // five standard deviations of a variance of so many
  Random random(2);
  const GaussianPose2 a = randomPose(random, 0.002), b = randomPose(random, 0.002);
  const Eigen::Matrix3d root_a = a.covariance.llt().matrixL();
  const Eigen::Matrix3d root_b = b.covariance.llt().matrixL();
  for (const Case& c : casesOf(a, b)) {
    const Eigen::LLT<Eigen::Matrix3d> root(c.found.covariance);
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (int i = 0; i < kDraws; ++i) {
      const Vector6d draw = gaussian(random);
      const Pose2 drawn = c.f(root_a * draw.head<3>(), root_b * draw.tail<3>());
      const Eigen::Vector3d error = (c.found.mean.inverse() * drawn).log();
      const Eigen::Vector3d unit = root.matrixL().solve(error);
      scatter += unit * unit.transpose() / kDraws;
    }
    EXPECT_LT((scatter - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), kTolerance)
        << c.name << '\n'
        << scatter;
  }
}

TEST(PoseCovariance, OfCorrelatedPosesCountsWhatTheyShare) {
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    GaussianPose2 a = randomPose(random, 0.1), b = randomPose(random, 0.1);
    const Matrix6d joint = randomCovariance<6>(random, 0.1);
    a.covariance = joint.topLeftCorner<3, 3>();
    b.covariance = joint.bottomRightCorner<3, 3>();
    const GaussianPose2 found = between(a, b, joint.topRightCorner<3, 3>());
    const auto jacobian = differences(casesOf(a, b)[2].f);
    expectNear(found.covariance, jacobian * joint * jacobian.transpose(), 1e-8);
    expectCovariance(found.covariance);
  }
}

TEST(PoseCovariance, BetweenTwoPartsOfOneBodyIsZero) {
  Random random(4);
  const GaussianPose2 a = randomPose(random, 0.1);
  const Pose2 a_T_b(3.0, -2.0, 1.0);
  const GaussianPose2 b = transported(a, a_T_b);
  // t_b = Ad(b_T_a) t_a, so E[t_a t_b'] = C_a Ad(b_T_a)'.
  const Eigen::Matrix3d cross = a.covariance * a_T_b.inverse().adjoint().transpose();
  EXPECT_LT(between(a, b, cross).covariance.cwiseAbs().maxCoeff(), 1e-15);
}

TEST(PoseCovariance, OfThereAndBackIsTheSame) {
  Random random(5);
  for (int i = 0; i < 50; ++i) {
    const GaussianPose2 a = randomPose(random, 0.1), b = randomPose(random, 0.1);
    expectNear(inverse(inverse(a)).covariance, a.covariance, 1e-10);
    expectNear(transported(transported(a, b.mean), b.mean.inverse()).covariance, a.covariance,
               1e-10);
    expectNear(inverse(between(a, b)).covariance, between(b, a).covariance, 1e-10);
  }
}

TEST(PoseCovariance, StaysACovarianceAlongALongChain) {
  Random random(6);
  GaussianPose2 pose;
  for (int i = 0; i < 2000; ++i) {
    const Pose2 step(random.uniform(0.0, 0.2), random.uniform(-0.1, 0.1),
                     random.uniform(-0.2, 0.2));
    Eigen::Matrix3d covariance = randomCovariance<3>(random, 0.01);
    if (i % 3 == 0) covariance = Eigen::Vector3d(1e-4, 0.0, 0.0).asDiagonal();  // singular
    pose = compose(pose, {step, covariance});
  }
  const double size = pose.covariance.cwiseAbs().maxCoeff();
  EXPECT_LT((pose.covariance - pose.covariance.transpose()).cwiseAbs().maxCoeff(), 1e-12 * size);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(pose.covariance).eigenvalues()(0), 0.0);
}

// ---- in the axes of map

TEST(MapCovariance, IsThatOfTheDifferenceOfTheNumbers) {
  Random random(7);
  for (int i = 0; i < 50; ++i) {
    const GaussianPose2 pose = randomPose(random, 0.1);
    constexpr double kStep = 1e-5;
    Eigen::Matrix3d jacobian;
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(j);
      jacobian.col(j) = offsetBetween(pose.mean * Pose2::exp(-step), pose.mean * Pose2::exp(step)) /
                        (2.0 * kStep);
    }
    const Eigen::Matrix3d in_map = mapCovariance(pose.covariance, pose.mean);
    expectNear(in_map, jacobian * pose.covariance * jacobian.transpose(), 1e-8);
    expectNear(tangentCovariance(in_map, pose.mean), pose.covariance, 1e-14);
    EXPECT_EQ(in_map(2, 2), pose.covariance(2, 2));
    expectCovariance(in_map);
  }
}

TEST(MapCovariance, OfAnotherPointIsThatOfTheTangentSpace) {
  Random random(8);
  for (int i = 0; i < 50; ++i) {
    const GaussianPose2 a = randomPose(random, 0.1);
    const Pose2 a_T_b = randomPose(random, 0.1).mean;
    const GaussianPose2 b = transported(a, a_T_b);
    const Eigen::Matrix3d found = transported(mapCovariance(a.covariance, a.mean),
                                              b.mean.translation() - a.mean.translation());
    expectNear(found, mapCovariance(b.covariance, b.mean), 1e-12);
    expectCovariance(found);
  }
}

TEST(MapCovariance, AYawErrorMovesADistantPointSideways) {
  const Eigen::Matrix3d yaw = Eigen::Vector3d(0.0, 0.0, 1e-4).asDiagonal();
  const Eigen::Matrix3d result = transported(yaw, {10.0, 0.0});
  EXPECT_NEAR(result(0, 0), 0.0, 1e-12);
  EXPECT_NEAR(result(1, 1), 1e-2, 1e-12);
  EXPECT_NEAR(result(1, 2), 1e-3, 1e-12);
}

TEST(MapCovariance, AQuarterTurnSwapsTheAxes) {
  Eigen::Matrix3d covariance;
  covariance << 4.0, 1.0, 0.5, 1.0, 2.0, 0.25, 0.5, 0.25, 1.0;
  Eigen::Matrix3d expected;
  expected << 2.0, -1.0, -0.25, -1.0, 4.0, 0.5, -0.25, 0.5, 1.0;
  expectNear(rotated(covariance, kPi / 2.0), expected, 1e-15);
}

}  // namespace
}  // namespace kestrel
