// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <functional>
#include <vector>

namespace kestrel {

/// The samples that a group is tested with. Each group specializes it with
///   kDof, kDim            of a tangent vector and of the points that the group acts on
///   elements()            of the group
///   tangents()            that log gives back: no angle is beyond its range
///   farTangents()         whose angle exp wraps
///   isNearJump(t)         whether log jumps near exp(t)
///   points()
template <typename Group>
struct LieGroupSamples;

/// The properties that every Lie group of the package has, in the manner of manif's tests.
/// Jacobians are compared with central differences; all changes are on the right, X * exp(t).
template <typename Group>
class LieGroupTest : public testing::Test {
 public:
  using Samples = LieGroupSamples<Group>;
  static constexpr int kDof = Samples::kDof, kDim = Samples::kDim;
  using Tangent = Eigen::Matrix<double, kDof, 1>;
  using Jacobian = Eigen::Matrix<double, kDof, kDof>;
  using Point = Eigen::Matrix<double, kDim, 1>;

  static constexpr double kRounding = 1e-14;   ///< relative
  static constexpr double kStep = 1e-5;        ///< of the differences
  static constexpr double kDerivative = 1e-8;  ///< relative error of the differences

  /// Relative to the largest number of `expected`, or to 1.
  template <typename Matrix>
  static void expectNear(const Matrix& found, const Matrix& expected, double tolerance) {
    const double scale = std::max(1.0, expected.cwiseAbs().maxCoeff());
    EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), tolerance * scale)
        << "found\n"
        << found << "\nexpected\n"
        << expected;
  }

  /// The same element; `scale` is the size of the largest numbers that led to it.
  static void expectSame(const Group& found, const Group& expected, double scale = 1.0) {
    const Tangent difference = (expected.inverse() * found).log();
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), 10.0 * kRounding * std::max(1.0, scale))
        << difference.transpose();
  }

  static double sizeOf(const Group& x) { return x.log().cwiseAbs().maxCoeff(); }

  /// The derivative of `f` at a tangent vector of zero.
  template <int Rows>
  static Eigen::Matrix<double, Rows, kDof> differences(
      const std::function<Eigen::Matrix<double, Rows, 1>(const Tangent&)>& f) {
    Eigen::Matrix<double, Rows, kDof> result;
    for (int i = 0; i < kDof; ++i) {
      const Tangent step = kStep * Tangent::Unit(i);
      result.col(i) = (f(step) - f(-step)) / (2.0 * kStep);
    }
    return result;
  }

  /// The derivative of an element of the group that depends on a tangent vector.
  static Jacobian groupDifferences(const std::function<Group(const Tangent&)>& f) {
    const Group undo = f(Tangent::Zero()).inverse();
    return differences<kDof>([&](const Tangent& d) { return (undo * f(d)).log(); });
  }

  static std::vector<Tangent> allTangents() {
    std::vector<Tangent> all = Samples::tangents();
    for (const Tangent& t : Samples::farTangents()) all.push_back(t);
    return all;
  }

  static void identityChangesNothing() {
    for (const Group& x : Samples::elements()) {
      expectSame(x * Group(), x);
      expectSame(Group() * x, x);
    }
  }

  static void inverseUndoes() {
    for (const Group& x : Samples::elements()) {
      const double scale = sizeOf(x);
      expectSame(x * x.inverse(), Group(), scale);
      expectSame(x.inverse() * x, Group(), scale);
      expectSame(x.inverse().inverse(), x, scale);
    }
  }

  static void isAssociative() {
    const auto elements = Samples::elements();
    for (std::size_t i = 0; i + 2 < elements.size(); ++i) {
      const Group &a = elements[i], &b = elements[i + 1], &c = elements[i + 2];
      const double scale = sizeOf(a) + sizeOf(b) + sizeOf(c);
      expectSame((a * b) * c, a * (b * c), scale);
      expectSame((a * b).inverse(), b.inverse() * a.inverse(), scale);
    }
  }

  static void actionIsThatOfTheProduct() {
    const auto elements = Samples::elements();
    for (std::size_t i = 0; i + 1 < elements.size(); ++i) {
      const Group &a = elements[i], &b = elements[i + 1];
      const double scale = 1.0 + sizeOf(a) + sizeOf(b);
      for (const auto& p : Samples::points()) {
        EXPECT_LE((a * b * p - a * (b * p)).norm(), 10.0 * kRounding * scale);
      }
    }
  }

  static void logOfExpIsTheTangent() {
    EXPECT_EQ(Group().log(), Tangent::Zero());
    expectSame(Group::exp(Tangent::Zero()), Group());
    for (const auto& t : Samples::tangents()) {
      const Tangent found = Group::exp(t).log();
      expectNear(found, t, kRounding);
    }
  }

  static void expOfLogIsTheElement() {
    for (const Group& x : Samples::elements()) {
      expectSame(Group::exp(x.log()), x, sizeOf(x));
    }
    for (const auto& t : allTangents()) {
      const Group x = Group::exp(t);
      expectSame(Group::exp(x.log()), x, sizeOf(x));
    }
  }

  /// exp(s t) for a growing s is a motion of constant velocity: it is made of equal steps.
  static void expIsMadeOfSmallSteps() {
    constexpr int kSteps = 64;
    for (const auto& t : allTangents()) {
      const Group step = Group::exp(t / kSteps);
      Group x;
      for (int i = 0; i < kSteps; ++i) x = x * step;
      expectSame(x, Group::exp(t), kSteps * t.norm());
    }
  }

  static void adjointMovesAChangeToTheOtherSide() {
    for (const Group& x : Samples::elements()) {
      for (const auto& t : allTangents()) {
        const Tangent moved = x.adjoint() * t;
        const double scale = sizeOf(x) * (1.0 + moved.norm());
        expectSame(x * Group::exp(t) * x.inverse(), Group::exp(moved), scale);
      }
    }
  }

  static void adjointOfProductIsProductOfAdjoints() {
    const auto elements = Samples::elements();
    for (std::size_t i = 0; i + 1 < elements.size(); ++i) {
      const Group &a = elements[i], &b = elements[i + 1];
      const Jacobian product = a.adjoint() * b.adjoint();
      expectNear((a * b).adjoint(), product, 10.0 * kRounding);
      const Jacobian inverse = a.inverse().adjoint() * a.adjoint();
      const double scale = 1.0 + sizeOf(a);
      expectNear(inverse, Jacobian(Jacobian::Identity()), 10.0 * kRounding * scale);
    }
  }

  static void inverseHasItsJacobian() {
    for (const Group& x : Samples::elements()) {
      Jacobian J_inverse_x;
      EXPECT_EQ(x.inverse(&J_inverse_x), x.inverse());
      const auto expected =
          groupDifferences([&](const auto& t) { return (x * Group::exp(t)).inverse(); });
      expectNear(J_inverse_x, expected, kDerivative);
    }
  }

  static void composeHasItsJacobians() {
    const auto elements = Samples::elements();
    for (std::size_t i = 0; i + 1 < elements.size(); ++i) {
      const Group &a = elements[i], &b = elements[i + 1];
      Jacobian J_c_a, J_c_b;
      EXPECT_EQ(a.compose(b, &J_c_a, &J_c_b), a * b);
      const auto by_a = groupDifferences([&](const auto& t) { return a * Group::exp(t) * b; });
      const auto by_b = groupDifferences([&](const auto& t) { return a * (b * Group::exp(t)); });
      expectNear(J_c_a, by_a, kDerivative);
      expectNear(J_c_b, by_b, kDerivative);
    }
  }

  static void betweenHasItsJacobians() {
    const auto elements = Samples::elements();
    for (std::size_t i = 0; i + 1 < elements.size(); ++i) {
      const Group &a = elements[i], &b = elements[i + 1];
      Jacobian J_c_a, J_c_b;
      expectSame(a * a.between(b, &J_c_a, &J_c_b), b, sizeOf(a) + sizeOf(b));
      const auto by_a =
          groupDifferences([&](const auto& t) { return (a * Group::exp(t)).between(b); });
      const auto by_b =
          groupDifferences([&](const auto& t) { return a.between(b * Group::exp(t)); });
      expectNear(J_c_a, by_a, kDerivative);
      expectNear(J_c_b, by_b, kDerivative);
    }
  }

  static void actHasItsJacobians() {
    for (const Group& x : Samples::elements()) {
      for (const auto& p : Samples::points()) {
        Eigen::Matrix<double, kDim, kDof> J_q_x;
        Eigen::Matrix<double, kDim, kDim> J_q_p;
        EXPECT_EQ(x.act(p, &J_q_x, &J_q_p), x * p);
        const auto by_x =
            differences<kDim>([&](const auto& t) { return Point(x * Group::exp(t) * p); });
        expectNear(J_q_x, by_x, kDerivative);
        for (int i = 0; i < kDim; ++i) {  // linear in p
          const Point column = x * Point(p + Point::Unit(i)) - x * p;
          expectNear(Point(J_q_p.col(i)), column, kDerivative * (1.0 + sizeOf(x)));
        }
      }
    }
  }

  static void expHasItsJacobians() {
    for (const auto& t : allTangents()) {
      Jacobian J_x_t;
      const Group x = Group::exp(t, &J_x_t);
      const auto right = groupDifferences([&](const Tangent& d) { return Group::exp(t + d); });
      const auto left = differences<kDof>(
          [&](const Tangent& d) { return (Group::exp(t + d) * x.inverse()).log(); });
      expectNear(J_x_t, right, kDerivative);
      expectNear(Group::rightJacobian(t), right, kDerivative);
      expectNear(Group::leftJacobian(t), left, kDerivative);
      const Jacobian moved = x.adjoint() * J_x_t;
      expectNear(Group::leftJacobian(t), moved, 10.0 * kRounding);
    }
  }

  /// No differences are taken where log jumps. The Jacobian is the inverse of that of exp there
  /// too.
  static void logHasItsJacobian() {
    for (const auto& t : Samples::tangents()) {
      const Group x = Group::exp(t);
      Jacobian J_t_x;
      EXPECT_EQ(x.log(&J_t_x), x.log());
      const double scale = 1.0 + t.norm();
      expectNear(Jacobian(J_t_x * Group::rightJacobian(t)), Jacobian(Jacobian::Identity()),
                 10.0 * kRounding * scale);
      if (Samples::isNearJump(t)) continue;
      const auto expected =
          differences<kDof>([&](const auto& d) { return (x * Group::exp(d)).log(); });
      expectNear(J_t_x, expected, kDerivative);
    }
  }
};

TYPED_TEST_SUITE_P(LieGroupTest);

TYPED_TEST_P(LieGroupTest, IdentityChangesNothing) { this->identityChangesNothing(); }
TYPED_TEST_P(LieGroupTest, InverseUndoes) { this->inverseUndoes(); }
TYPED_TEST_P(LieGroupTest, IsAssociative) { this->isAssociative(); }
TYPED_TEST_P(LieGroupTest, ActionIsThatOfTheProduct) { this->actionIsThatOfTheProduct(); }
TYPED_TEST_P(LieGroupTest, LogOfExpIsTheTangent) { this->logOfExpIsTheTangent(); }
TYPED_TEST_P(LieGroupTest, ExpOfLogIsTheElement) { this->expOfLogIsTheElement(); }
TYPED_TEST_P(LieGroupTest, ExpIsMadeOfSmallSteps) { this->expIsMadeOfSmallSteps(); }
TYPED_TEST_P(LieGroupTest, AdjointMovesAChangeToTheOtherSide) {
  this->adjointMovesAChangeToTheOtherSide();
}
TYPED_TEST_P(LieGroupTest, AdjointOfProductIsProductOfAdjoints) {
  this->adjointOfProductIsProductOfAdjoints();
}
TYPED_TEST_P(LieGroupTest, InverseHasItsJacobian) { this->inverseHasItsJacobian(); }
TYPED_TEST_P(LieGroupTest, ComposeHasItsJacobians) { this->composeHasItsJacobians(); }
TYPED_TEST_P(LieGroupTest, BetweenHasItsJacobians) { this->betweenHasItsJacobians(); }
TYPED_TEST_P(LieGroupTest, ActHasItsJacobians) { this->actHasItsJacobians(); }
TYPED_TEST_P(LieGroupTest, ExpHasItsJacobians) { this->expHasItsJacobians(); }
TYPED_TEST_P(LieGroupTest, LogHasItsJacobian) { this->logHasItsJacobian(); }

REGISTER_TYPED_TEST_SUITE_P(LieGroupTest, IdentityChangesNothing, InverseUndoes, IsAssociative,
                            ActionIsThatOfTheProduct, LogOfExpIsTheTangent, ExpOfLogIsTheElement,
                            ExpIsMadeOfSmallSteps, AdjointMovesAChangeToTheOtherSide,
                            AdjointOfProductIsProductOfAdjoints, InverseHasItsJacobian,
                            ComposeHasItsJacobians, BetweenHasItsJacobians, ActHasItsJacobians,
                            ExpHasItsJacobians, LogHasItsJacobian);

}  // namespace kestrel
