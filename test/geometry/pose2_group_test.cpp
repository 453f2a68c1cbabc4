// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/lie_group_tester.h"
#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/geometry/random.h"

namespace kestrel {

template <>
struct LieGroupSamples<Pose2> {
  static constexpr int kDof = 3, kDim = 2;

  /// All edge values of the yaw with all of the position.
  static std::vector<Eigen::Vector3d> with(const std::vector<double>& yaws) {
    std::vector<Eigen::Vector3d> result;
    for (const double yaw : yaws) {
      for (const double size : {0.0, 1e-10, 1e-5, 1.0, 30.0}) {
        result.emplace_back(size, -0.7 * size, yaw);
      }
    }
    return result;
  }

  /// 0.1 is where a power series takes over.
  static std::vector<Eigen::Vector3d> tangents() {
    return with({0.0, 1e-10, -1e-10, 1e-5, -1e-5, 0.099999, 0.100001, -0.100001, 1.0, -2.0,
                 kPi - 1e-5, -kPi + 1e-5, kPi - 1e-10, -kPi + 1e-10, kPi});
  }

  static std::vector<Eigen::Vector3d> farTangents() {
    return with({-kPi, kPi + 1e-10, -kPi - 1e-5, 4.0, -2.0 * kPi, 2.0 * kPi + 1e-5, 20.0});
  }

  static bool isNearJump(const Eigen::Vector3d& t) { return std::abs(t.z()) > kPi - 1e-3; }

  static std::vector<Pose2> elements() {
    std::vector<Pose2> result;
    for (const Eigen::Vector3d& t : tangents()) result.emplace_back(t.x(), t.y(), t.z());
    Random random(3);
    constexpr int kRandom = 40;
    for (int i = 0; i < kRandom; ++i) {
      const double x = random.uniform(-50.0, 50.0), y = random.uniform(-50.0, 50.0);
      result.insert(result.begin() + 2 * i, Pose2(x, y, random.uniform(-kPi, kPi)));
    }
    return result;
  }

  static std::vector<Eigen::Vector2d> points() {
    return {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, {-3.0, 20.0}};
  }
};

INSTANTIATE_TYPED_TEST_SUITE_P(Pose2, LieGroupTest, Pose2);

namespace {

/// Jr(t) = I - ad / 2! + ad² / 3! - ..., where ad is the derivative of the adjoint: an oracle
/// without cancellation at small angles.
TEST(Pose2Exp, RightJacobianIsItsPowerSeries) {
  constexpr int kTerms = 40;
  for (const Eigen::Vector3d& t : LieGroupSamples<Pose2>::tangents()) {
    Eigen::Matrix3d ad;
    ad << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), 0.0, 0.0, 0.0;
    Eigen::Matrix3d term = Eigen::Matrix3d::Identity(), sum = term;
    for (int i = 2; i < kTerms; ++i) {
      term = -term * ad / i;
      sum += term;
    }
    LieGroupTest<Pose2>::expectNear(Pose2::rightJacobian(t), sum, 1e-14);
  }
}

}  // namespace
}  // namespace kestrel
