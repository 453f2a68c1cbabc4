// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/icp.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace kestrel {
namespace {

constexpr std::uint64_t kSeed = 3;

Eigen::Vector2f randomPoint(std::mt19937_64& random, float size) {
  std::uniform_real_distribution<float> place(-size, size);
  const float x = place(random);
  return {x, place(random)};
}

/// Random points in the base frame and their positions in the map frame, m. The partners have
/// noise.
std::vector<IcpPair> randomPairs(const Pose2& map_T_base, int count, float noise_m) {
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<float> angle(-3.1F, 3.1F);
  std::vector<IcpPair> pairs;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2f p = randomPoint(random, 10.0F);
    const Eigen::Vector2f q = (map_T_base * p.cast<double>()).cast<float>();
    const float direction = angle(random);
    pairs.push_back({p, q + randomPoint(random, noise_m),
                     Eigen::Vector2f(std::cos(direction), std::sin(direction))});
  }
  return pairs;
}

void expectNear(const Pose2& pose, const Pose2& expected, double tolerance) {
  EXPECT_NEAR(pose.x, expected.x, tolerance);
  EXPECT_NEAR(pose.y, expected.y, tolerance);
  EXPECT_NEAR(normalizeAngle(pose.yaw - expected.yaw), 0.0, tolerance);
}

/// Σ ((T p - q)·n)² [Siew 2018, eq. 9].
double lineError(const std::vector<IcpPair>& pairs, const Pose2& pose) {
  double sum = 0.0;
  for (const IcpPair& pair : pairs) {
    const Eigen::Vector2d e = pose * pair.point.cast<double>() - pair.partner.cast<double>();
    sum += std::pow(e.dot(pair.normal.cast<double>()), 2);
  }
  return sum;
}

/// Minimum of a function of the pose near `initial_guess`, by decreasing steps along the axes.
/// Slow, but without derivatives.
template <typename Cost>
Pose2 minimumOf(Cost cost, Pose2 initial_guess) {
  double best = cost(initial_guess);
  for (double step = 0.1; step > 1e-10;) {
    bool lower = false;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double signed_step : {step, -step}) {
        const Pose2 pose(initial_guess.x + (axis == 0 ? signed_step : 0.0),
                         initial_guess.y + (axis == 1 ? signed_step : 0.0),
                         initial_guess.yaw + (axis == 2 ? signed_step : 0.0));
        if (cost(pose) >= best) continue;
        best = cost(pose);
        initial_guess = pose;
        lower = true;
      }
    }
    if (!lower) step *= 0.5;
  }
  return initial_guess;
}

TEST(PointToPoint, RecoversARigidMotion) {
  for (const Pose2& truth : {Pose2(0.3, -0.2, 0.1), Pose2(-4.0, 7.0, 3.0), Pose2(0, 0, -1.6)}) {
    // Float coordinates of 10 m are accurate to half a micrometer.
    expectNear(alignPointToPoint(randomPairs(truth, 500, 0.0F), Pose2()), truth, 1e-6);
  }
}

TEST(PointToPoint, EqualsUmeyama) {
  const std::vector<IcpPair> pairs = randomPairs(Pose2(1.0, 2.0, 2.5), 200, 0.5F);
  Eigen::MatrixXd from(2, 200), to(2, 200);
  for (Eigen::Index i = 0; i < 200; ++i) {
    from.col(i) = pairs[static_cast<std::size_t>(i)].point.cast<double>();
    to.col(i) = pairs[static_cast<std::size_t>(i)].partner.cast<double>();
  }
  const Eigen::MatrixXd oracle = Eigen::umeyama(from, to, false);
  expectNear(alignPointToPoint(pairs, Pose2()),
             Pose2(oracle(0, 2), oracle(1, 2), std::atan2(oracle(1, 0), oracle(0, 0))), 1e-9);
}

TEST(PointToPoint, KeepsTheInitialGuessWhereThePairsAreAmbiguous) {
  const Pose2 initial_guess(1.0, 2.0, 0.5);
  EXPECT_EQ(alignPointToPoint({}, initial_guess), initial_guess);
  // One point determines the position, but not the yaw.
  const Eigen::Vector2f p(1.0F, 0.0F), q(3.0F, 3.0F), none = Eigen::Vector2f::Zero();
  const Pose2 one = alignPointToPoint({{p, q, none}}, initial_guess);
  EXPECT_EQ(one.yaw, 0.5);
  EXPECT_NEAR((one * p.cast<double>() - q.cast<double>()).norm(), 0.0, 1e-12);
  const Pose2 same = alignPointToPoint({{p, q, none}, {p, q, none}, {p, q, none}}, initial_guess);
  EXPECT_NEAR(same.yaw, 0.5, 1e-12);
  // Two points and collinear points determine the pose.
  for (const int count : {2, 5}) {
    std::vector<IcpPair> line;
    for (int i = 0; i < count; ++i) {
      const auto s = static_cast<float>(i);
      line.push_back({{s, 0.0F}, {2.0F, 1.0F + s}, none});
    }
    expectNear(alignPointToPoint(line, initial_guess), Pose2(2.0, 1.0, kPi / 2), 1e-6);
  }
}

TEST(PointToLine, RecoversARigidMotion) {
  const Pose2 truth(3.0, -2.0, 0.9);
  expectNear(alignPointToLine(randomPairs(truth, 500, 0.0F), truth * Pose2(0.3, -0.2, 0.2)), truth,
             1e-6);
}

TEST(PointToLine, EqualsTheNumericMinimum) {
  const Pose2 truth(3.0, -2.0, 0.9), initial_guess = truth * Pose2(0.1, 0.1, -0.05);
  const std::vector<IcpPair> pairs = randomPairs(truth, 60, 0.3F);
  const Pose2 oracle =
      minimumOf([&](const Pose2& pose) { return lineError(pairs, pose); }, initial_guess);
  const Pose2 pose = alignPointToLine(pairs, initial_guess);
  expectNear(pose, oracle, 1e-6);
  EXPECT_LE(lineError(pairs, pose), lineError(pairs, oracle) * (1.0 + 1e-9));
}

TEST(PointToLine, WithoutNormalsIsPointToPoint) {
  std::vector<IcpPair> pairs = randomPairs(Pose2(0.2, 0.1, 0.05), 50, 0.2F);
  for (IcpPair& pair : pairs) pair.normal.setZero();
  expectNear(alignPointToLine(pairs, Pose2()), alignPointToPoint(pairs, Pose2()), 1e-6);
}

TEST(PointToLine, KeepsTheInitialGuessInUnobservableDirections) {
  const Pose2 initial_guess(5.0, 6.0, 0.0);
  EXPECT_EQ(alignPointToLine({}, initial_guess), initial_guess);
  // A wall along x, 0.3 m to the left of the points.
  std::vector<IcpPair> wall;
  for (int i = -20; i <= 20; ++i) {
    const auto s = static_cast<float>(i);
    wall.push_back({{s, 1.0F}, {5.05F + s, 7.3F}, Eigen::Vector2f::UnitY()});
  }
  expectNear(alignPointToLine(wall, initial_guess), Pose2(5.0, 6.3, 0.0), 1e-5);
  // One pair: no NaN and only a small rotation.
  const Pose2 one = alignPointToLine({wall.front()}, initial_guess);
  EXPECT_TRUE(one.isFinite());
  EXPECT_LT((initial_guess.inverse() * one).distance(), 0.31);
  EXPECT_LT(std::abs(one.yaw), 0.1);
}

TEST(RejectWorstPairs, RemovesExactlyTheOutliers) {
  std::mt19937_64 random(kSeed);
  std::vector<IcpPair> pairs = randomPairs(Pose2(), 100, 0.0F);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].error = static_cast<float>(i) * 1e-4F;
    if (i % 10 == 3) pairs[i].error += 1.0F;
  }
  std::shuffle(pairs.begin(), pairs.end(), random);
  rejectWorstPairs(pairs, 0.1);
  ASSERT_EQ(pairs.size(), 90U);
  for (const IcpPair& pair : pairs) EXPECT_LT(pair.error, 1.0F);
  rejectWorstPairs(pairs, 0.0);
  EXPECT_EQ(pairs.size(), 90U);
  rejectWorstPairs(pairs, 0.999);
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs.front().error, 0.0F);
  rejectWorstPairs(pairs, 0.9);
  EXPECT_EQ(pairs.size(), 1U) << "the count is rounded down";
  pairs.clear();
  rejectWorstPairs(pairs, 0.5);
  EXPECT_TRUE(pairs.empty());
}

}  // namespace
}  // namespace kestrel
