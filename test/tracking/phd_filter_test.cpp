// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/phd_filter.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "component_at.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/random.h"

namespace kestrel {
namespace {

using Vector2 = Eigen::Vector2d;
using Vector4 = Eigen::Vector4d;
using Matrix4 = Eigen::Matrix4d;

PhdModel<4, 2> modelWith(double detection, double survival, double clutter) {
  PhdModel<4, 2> model;
  model.motions = {constantVelocity<4, 2>(1.0)};
  model.survival = [survival](const Vector4&) { return survival; };
  model.detection = [detection](const auto&) { return detection; };
  model.clutter = [clutter](const Vector2&) { return clutter; };
  model.expect = expectPosition<4, 2>;
  return model;
}

Observation<2> observationAt(double x, double y, double sigma = 0.1) {
  return {{x, y}, Eigen::Matrix2d::Identity() * sigma * sigma};
}

/// Textbook Kalman filter, written independently of the filter under test.
struct Kalman {
  Vector4 mean;
  Matrix4 covariance;

  /// Constant velocity with an acceleration of 1 m/s².
  void predict(double seconds) {
    Matrix4 F = Matrix4::Identity();
    F.topRightCorner<2, 2>() = seconds * Eigen::Matrix2d::Identity();
    Eigen::Matrix<double, 4, 2> G;
    G << 0.5 * seconds * seconds * Eigen::Matrix2d::Identity(),
        seconds * Eigen::Matrix2d::Identity();
    mean = (F * mean).eval();
    covariance = (F * covariance * F.transpose() + G * G.transpose()).eval();
  }
  void update(const Eigen::MatrixXd& H, const Eigen::VectorXd& error, const Eigen::MatrixXd& R) {
    const Eigen::MatrixXd S = H * covariance * H.transpose() + R;
    const Eigen::MatrixXd K = covariance * H.transpose() * S.inverse();
    mean += K * error;
    covariance = (Matrix4::Identity() - K * H) * covariance;
  }
};

TEST(PhdFilter, OneTargetWithoutClutterIsAKalmanFilter) {
  PhdFilter<4, 2> filter(modelWith(1.0, 1.0, 0.0));
  PhdComponent<4> start = componentAt(0.0, 0.0, 1.0, 0.5);
  Kalman kalman{start.mean, start.covariance};
  Random random(1);
  const Eigen::MatrixXd H = Eigen::MatrixXd::Identity(2, 4);
  // The birth is not moved by the prediction: it is born without an observation.
  filter.predict(0.0, {start});
  for (int i = 1; i <= 200; ++i) {
    const Observation<2> z =
        observationAt(0.1 * i + 0.1 * random.gaussian(), 0.05 * i + 0.1 * random.gaussian());
    if (i > 1) filter.predict(0.1, {});
    filter.update({z});
    kalman.predict(i > 1 ? 0.1 : 0.0);
    kalman.update(H, z.value - kalman.mean.head<2>(), z.noise);
    ASSERT_EQ(filter.components().size(), 1U);
    const PhdComponent<4>& component = filter.components().front();
    ASSERT_NEAR(component.weight, 1.0, 1e-9);
    ASSERT_LT((component.mean - kalman.mean).norm(), 1e-9);
    ASSERT_LT((component.covariance - kalman.covariance).norm(), 1e-9);
  }
}

ExpectedObservation<4, 2> rangeAndBearing(const Vector4& state) {
  ExpectedObservation<4, 2> expected;
  const double x = state(0), y = state(1), r = std::hypot(x, y);
  expected.value << r, std::atan2(y, x);
  expected.jacobian.emplace().setZero();
  expected.jacobian->leftCols<2>() << x / r, y / r, -y / (r * r), x / (r * r);
  return expected;
}

TEST(PhdFilter, RangeAndBearingIsAnExtendedKalmanFilter) {
  PhdModel<4, 2> model = modelWith(1.0, 1.0, 0.0);
  model.expect = rangeAndBearing;
  model.difference = [](const Vector2& a, const Vector2& b) {
    return Vector2(a.x() - b.x(), normalizeAngle(a.y() - b.y()));
  };
  PhdFilter<4, 2> filter(model);
  // It crosses the negative x axis, where the bearing jumps by 2 pi.
  PhdComponent<4> start = componentAt(-5.0, 1.0, 0.0, -1.0);
  Kalman kalman{start.mean, start.covariance};
  filter.predict(0.0, {start});
  Random random(2);
  const Eigen::Matrix2d R = Vector2(0.01, 0.0004).asDiagonal();
  for (int i = 0; i < 40; ++i) {
    const double seconds = i > 0 ? 0.05 : 0.0, y = 1.0 - 0.05 * i;
    const Vector2 z(std::hypot(5.0, y) + 0.1 * random.gaussian(),
                    normalizeAngle(std::atan2(y, -5.0) + 0.02 * random.gaussian()));
    if (i > 0) filter.predict(seconds, {});
    filter.update({{z, R}});
    kalman.predict(seconds);
    const ExpectedObservation<4, 2> expected = rangeAndBearing(kalman.mean);
    const Vector2 error(z.x() - expected.value.x(), normalizeAngle(z.y() - expected.value.y()));
    kalman.update(*expected.jacobian, error, R);
    ASSERT_EQ(filter.components().size(), 1U);
    ASSERT_LT((filter.components().front().mean - kalman.mean).norm(), 1e-9);
  }
  EXPECT_LT((kalman.mean.head<2>() - Vector2(-5.0, -0.95)).norm(), 0.1);
}

TEST(PhdFilter, PositionNeedsNoJacobian) {
  PhdModel<4, 2> with_jacobian = modelWith(0.9, 0.99, 0.1);
  with_jacobian.expect = [](const Vector4& state) {
    return ExpectedObservation<4, 2>{state.head<2>(), Eigen::Matrix<double, 2, 4>::Identity()};
  };
  PhdFilter<4, 2> expected(with_jacobian), filter(modelWith(0.9, 0.99, 0.1));
  for (int i = 0; i < 20; ++i) {
    const double x = 0.1 * i;
    for (PhdFilter<4, 2>* f : {&expected, &filter}) {
      f->predict(0.1, {componentAt(x, 0.0, 1.0, 0.5, 0.2), componentAt(5.0, x, 0.0, 0.0, 0.2)});
      f->update({observationAt(x, 0.05), observationAt(5.1, x)});
    }
    ASSERT_EQ(filter.components().size(), expected.components().size());
    for (std::size_t k = 0; k < filter.components().size(); ++k) {
      const PhdComponent<4>&a = filter.components()[k], &b = expected.components()[k];
      EXPECT_NEAR(a.weight, b.weight, 1e-12);
      EXPECT_LT((a.mean - b.mean).norm(), 1e-12);
      EXPECT_LT((a.covariance - b.covariance).norm(), 1e-12);
    }
  }
}

TEST(PhdFilter, WeightsFollowTheUpdateEquation) {
  // [Siew 2018, eq. 25-28] by hand, for two components and one observation.
  PhdFilter<4, 2> filter(modelWith(0.8, 1.0, 0.3));
  filter.predict(0.0, {componentAt(0, 0, 0, 0, 0.7), componentAt(3, 0, 0, 0, 0.2)});
  filter.update({observationAt(0.1, 0.0)});
  const auto density = [](double distance2) {
    return std::exp(-0.5 * distance2 / 0.05) / (2.0 * kPi * 0.05);
  };
  const double q1 = 0.8 * 0.7 * density(0.01), q2 = 0.8 * 0.2 * density(2.9 * 2.9);
  const double expected = 0.2 * 0.9 + (q1 + q2) / (0.3 + q1 + q2);
  EXPECT_NEAR(filter.expectedCount(), expected, 1e-9);
  EXPECT_NEAR(filter.explained().at(0), (q1 + q2) / (0.3 + q1 + q2), 1e-12);
}

TEST(PhdFilter, HiddenTargetStays) {
  PhdModel<4, 2> model = modelWith(0.9, 0.99, 1e-3);
  model.detection = [](const PhdComponent<4>& c) { return c.mean.x() > 1.0 ? 0.0 : 0.9; };
  PhdFilter<4, 2> filter(model);
  filter.predict(0.0, {componentAt(2, 0, 0, 0)});
  for (int i = 0; i < 10; ++i) {
    filter.update({});
    filter.predict(0.1, {});
  }
  EXPECT_NEAR(filter.expectedCount(), std::pow(0.99, 10), 1e-9);
  filter.update({});
  ASSERT_EQ(filter.targets().size(), 1U);
  EXPECT_EQ(filter.targets().front().observation, -1);
}

// Most of its places are hidden, but the sensor sees the one where it comes back.
TEST(PhdFilter, HiddenTargetIsKnownWhereItComesBack) {
  PhdModel<4, 2> model = modelWith(0.9, 0.99, 0.02);
  model.detection = [](const PhdComponent<4>&) { return 0.02; };
  PhdComponent<4> hidden = componentAt(2, 0, 0, 0);
  hidden.covariance.topLeftCorner<2, 2>().setIdentity();
  const auto explainedIn = [&](PhdFilter<4, 2> filter) {
    filter.add({hidden});
    filter.update({observationAt(1.0, 0.0)});
    return filter.explained().at(0);
  };
  EXPECT_LT(explainedIn(PhdFilter<4, 2>(model)), 0.2);
  model.detection_where_seen = 0.9;
  EXPECT_GT(explainedIn(PhdFilter<4, 2>(model)), 0.7);
}

TEST(PhdFilter, WhatATargetMayBeTooHasItsLabel) {
  PhdFilter<4, 2> filter(modelWith(0.9, 0.99, 1e-3));
  filter.predict(0.0, {componentAt(0, 0, 0, 0)});
  PhdComponent<4> other = componentAt(0, 0, 0, 2);
  other.label = 1;
  filter.add({other, componentAt(5, 0, 0, 0)});
  ASSERT_EQ(filter.components().size(), 3U);
  EXPECT_EQ(filter.components()[1].label, 1U);
  EXPECT_EQ(filter.components()[2].label, 2U);
}

TEST(PhdFilter, MissedTargetKeepsTheWeightThatTheModelSays) {
  PhdModel<4, 2> model = modelWith(0.2, 1.0, 0.0);
  model.missed = [](double detection) { return detection < 0.3 ? 1.0 : 1.0 - detection; };
  PhdFilter<4, 2> filter(model);
  PhdComponent<4> target;
  target.weight = 0.8;
  filter.add({target});
  for (int i = 0; i < 50; ++i) filter.update({});
  EXPECT_NEAR(filter.expectedCount(), 0.8, 1e-12);
  filter.model().detection = [](const auto&) { return 0.5; };
  filter.update({});
  EXPECT_NEAR(filter.expectedCount(), 0.4, 1e-12);
}

TEST(PhdFilter, SpawnedTargetHasItsOwnLabel) {
  PhdModel<4, 2> model = modelWith(0.98, 0.99, 1e-4);
  SpawnModel<4> spawn;
  spawn.weight = 0.1;
  spawn.offset << 1.0, 0.0, 0.0, 0.0;
  model.spawns = {spawn};
  PhdFilter<4, 2> filter(model);
  filter.predict(0.0, {componentAt(0, 0, 0, 0)});
  filter.update({observationAt(0, 0)});
  filter.predict(0.1, {});
  filter.update({observationAt(0, 0), observationAt(1, 0)});
  ASSERT_EQ(filter.targets().size(), 2U);
  EXPECT_NE(filter.targets()[0].label, filter.targets()[1].label);
  EXPECT_EQ(filter.targets()[0].label, 1U);
  EXPECT_NEAR(filter.targets()[1].mean.x(), 1.0, 0.1);
}

/// Labels of the targets near y = -1 and y = 1 after two targets have crossed at the origin.
std::pair<TargetLabel, TargetLabel> labelsAfterCrossing(PhdFilter<4, 2>& filter) {
  filter.predict(0.0, {componentAt(-2, -1, 2, 1), componentAt(-2, 1, 2, -1)});
  Random random(3);
  for (int i = 0; i <= 40; ++i) {
    const double x = -2.0 + 0.1 * i, y = -1.0 + 0.05 * i;
    const auto noise = [&] { return 0.05 * random.gaussian(); };
    filter.update(
        {observationAt(x + noise(), y + noise()), observationAt(x + noise(), noise() - y)});
    filter.predict(0.05, {});
  }
  std::pair<TargetLabel, TargetLabel> labels;
  for (const auto& target : filter.targets()) {
    (target.mean.y() < 0.0 ? labels.first : labels.second) = target.label;
  }
  return labels;
}

TEST(PhdFilter, TargetsThatCrossKeepTheirLabels) {
  PhdFilter<4, 2> filter(modelWith(0.98, 0.999, 1e-3));
  EXPECT_EQ(labelsAfterCrossing(filter), std::pair(TargetLabel{2}, TargetLabel{1}));
}

TEST(PhdFilter, BirthsAtATargetDoNotTakeItsLabel) {
  PhdFilter<4, 2> filter(modelWith(0.95, 0.99, 1e-2));
  Random random(4);
  std::vector<PhdComponent<4>> births{componentAt(0, 0, 0, 0, 0.02)};
  filter.predict(0.0, births);
  TargetLabel label = 0;
  for (int i = 0; i < 100; ++i) {
    filter.update({observationAt(0.1 * random.gaussian(), 0.1 * random.gaussian())});
    ASSERT_LE(filter.targets().size(), 1U);
    if (!filter.targets().empty()) {
      if (label == 0) label = filter.targets().front().label;
      ASSERT_EQ(filter.targets().front().label, label) << i;
    }
    filter.predict(0.1, births);
  }
  EXPECT_NE(label, 0U);
}

TEST(PhdFilter, MotionModelFollowsATargetThatStops) {
  PhdModel<4, 2> model = modelWith(0.98, 0.999, 1e-3);
  model.motions = {constantVelocity<4, 2>(1.0), standing<4, 2>(0.02, 0.3)};
  model.mode_transition = Eigen::Matrix2d{{0.95, 0.05}, {0.05, 0.95}};
  PhdFilter<4, 2> filter(model);
  Random random(5);
  filter.predict(0.0, {componentAt(0, 0, 1, 0)});
  const auto standsAfter = [&](int scans, double speed, double& x) {
    for (int i = 0; i < scans; ++i) {
      x += 0.1 * speed;
      filter.predict(0.1, {});
      filter.update({observationAt(x + 0.02 * random.gaussian(), 0.02 * random.gaussian(), 0.02)});
    }
    return filter.targets().at(0).modes.at(1);
  };
  double x = 0.0;
  EXPECT_LT(standsAfter(20, 1.0, x), 0.1);
  EXPECT_GT(standsAfter(20, 0.0, x), 0.9);
  EXPECT_LT(filter.targets().at(0).mean.tail<2>().norm(), 0.05);
  EXPECT_LT(standsAfter(10, 1.0, x), 0.1);
  EXPECT_EQ(filter.targets().at(0).label, 1U);
}

TEST(PhdFilter, ForgottenLabelIsGone) {
  PhdFilter<4, 2> filter(modelWith(0.9, 0.99, 1e-3));
  filter.predict(0.0, {componentAt(0, 0, 0, 0), componentAt(5, 0, 0, 0)});
  ASSERT_TRUE(filter.find(1));
  filter.forget(1);
  EXPECT_FALSE(filter.find(1));
  EXPECT_TRUE(filter.find(2));
}

}  // namespace
}  // namespace kestrel
