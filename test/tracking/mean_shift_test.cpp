// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/mean_shift.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <set>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/tracking/object_box.h"

namespace kestrel {
namespace {

template <int D>
using PointsOf = std::vector<Eigen::Matrix<double, D, 1>>;

template <int D>
PointsOf<D> blobs(int count, int each, double spread, double region, Random& random) {
  PointsOf<D> points;
  for (int b = 0; b < count; ++b) {
    Eigen::Matrix<double, D, 1> center;
    for (int i = 0; i < D; ++i) center(i) = random.uniform(-region, region);
    for (int k = 0; k < each; ++k) {
      Eigen::Matrix<double, D, 1> point = center;
      for (int i = 0; i < D; ++i) point(i) += spread * random.gaussian();
      points.push_back(point);
    }
  }
  return points;
}

/// Mean shift over all points in every step.
template <int D>
Eigen::Matrix<double, D, 1> climbByBruteForce(const PointsOf<D>& points, double bandwidth,
                                              Eigen::Matrix<double, D, 1> at) {
  for (int step = 0; step < 1000; ++step) {
    Eigen::Matrix<double, D, 1> sum = Eigen::Matrix<double, D, 1>::Zero();
    double count = 0.0;
    for (const auto& point : points) {
      if ((point - at).squaredNorm() > bandwidth * bandwidth) continue;
      sum += point;
      count += 1.0;
    }
    if ((sum / count - at).norm() < 1e-12) break;
    at = sum / count;
  }
  return at;
}

template <int D>
void expectModesOfBruteForce() {
  Random random(D);
  for (int trial = 0; trial < 10; ++trial) {
    const PointsOf<D> points = blobs<D>(6, 25, 0.3, 4.0, random);
    const auto clusters = meanShift<D>(points, 0.8);
    std::set<std::size_t> seen;
    for (const auto& cluster : clusters) {
      for (const std::size_t i : cluster.points) {
        EXPECT_TRUE(seen.insert(i).second);
        EXPECT_LT((climb<D>(points, 0.8, points[i]) - climbByBruteForce<D>(points, 0.8, points[i]))
                      .norm(),
                  1e-9);
      }
      // The mode of a cluster is a fixed point.
      EXPECT_LT((climbByBruteForce<D>(points, 0.8, cluster.mode) - cluster.mode).norm(), 1e-9);
    }
    EXPECT_EQ(seen.size(), points.size());
  }
}

TEST(MeanShift, ModesEqualThoseOfBruteForce) {
  expectModesOfBruteForce<2>();
  expectModesOfBruteForce<3>();
}

TEST(MeanShift, SeparatesBlobs) {
  PointsOf<2> points;
  Random random(7);
  for (const double x : {0.0, 2.0, 4.0}) {
    for (int i = 0; i < 20; ++i)
      points.emplace_back(x + 0.1 * random.gaussian(), 0.1 * random.gaussian());
  }
  const auto clusters = meanShift<2>(points, 0.6);
  ASSERT_EQ(clusters.size(), 3U);
  for (int c = 0; c < 3; ++c) {
    const auto& cluster = clusters[static_cast<std::size_t>(c)];
    EXPECT_EQ(cluster.points.size(), 20U);
    EXPECT_NEAR(cluster.mode.x(), 2.0 * c, 0.1);
  }
  EXPECT_TRUE(meanShift<2>({}, 0.6).empty());
}

TEST(MeanShift, LongSurfaceIsJoined) {
  // A side of 3 m, denser at three places, and another object.
  PointsOf<2> points;
  for (int i = 0; i <= 30; ++i) points.emplace_back(0.1 * i, 0.0);
  for (const double x : {0.5, 1.5, 2.5}) points.insert(points.end(), 20, Eigen::Vector2d(x, 0.01));
  points.emplace_back(6.0, 0.0);
  const auto clusters = meanShift<2>(points, 0.3);
  EXPECT_GT(clusters.size(), 3U);
  const auto joined = joinConnected<2>(points, clusters, 0.15);
  ASSERT_EQ(joined.size(), 2U);
  EXPECT_EQ(joined[0].points.size(), 91U);
  EXPECT_NEAR(joined[0].mode.x(), 1.5, 1e-9);
}

/// Points on two sides of a rectangle of 4.5 m x 1.8 m that face the origin.
PointsOf<2> twoSides(const OrientedBox& box, double noise, Random& random) {
  const auto shape = lShapeOf(box, Eigen::Vector2d::Zero());
  PointsOf<2> points;
  for (int i = 0; i <= 30; ++i) {
    const double share = i / 30.0;
    const Eigen::Vector2d error(noise * random.gaussian(), noise * random.gaussian());
    points.push_back(shape->corner + share * (shape->first_end - shape->corner) + error);
    points.push_back(shape->corner + share * (shape->second_end - shape->corner) + error);
  }
  return points;
}

TEST(ObjectBox, LShapeGivesTheBoxOfTheVehicle) {
  Random random(3);
  for (int trial = 0; trial < 30; ++trial) {
    OrientedBox truth;
    truth.center = {8.0, 5.0};
    truth.size = {4.5, 1.8};
    truth.yaw = random.uniform(-1.5, 1.5);
    if (!lShapeOf(truth, Eigen::Vector2d::Zero())) continue;
    const OrientedBox box = fitBox(twoSides(truth, 0.01, random));
    EXPECT_LT((box.center - truth.center).norm(), 0.1) << truth.yaw;
    EXPECT_LT((box.size - truth.size).norm(), 0.15);
    EXPECT_LT(std::abs(std::sin(box.yaw - truth.yaw)), 0.035);
  }
}

TEST(ObjectBox, BoxAlongContainsAllPoints) {
  const OrientedBox box = boxAlong({{0, 0}, {1, 3}, {0.5, 1}}, 0.0);
  EXPECT_NEAR(box.size.x(), 3.0, 1e-12);
  EXPECT_NEAR(box.size.y(), 1.0, 1e-12);
  EXPECT_NEAR(std::abs(box.yaw), M_PI / 2.0, 1e-12);
  EXPECT_LT((box.center - Eigen::Vector2d(0.5, 1.5)).norm(), 1e-12);
  EXPECT_EQ(fitBox({}).size.norm(), 0.0);
}

TEST(ObjectBox, OneVisibleSideHasNoCorner) {
  OrientedBox box;
  box.center = {5.0, 0.0};
  box.size = {2.0, 1.0};
  EXPECT_FALSE(lShapeOf(box, Eigen::Vector2d::Zero()));
  EXPECT_TRUE(lShapeOf(box, Eigen::Vector2d(0.0, 2.0)));
}

TEST(ObjectBox, ContainsPointsUpToTheMarginAlongItsAxes) {
  const OrientedBox box{{2.0, 1.0}, {4.0, 2.0}, 0.5};
  const auto at = [&](double x, double y) -> Eigen::Vector2d {
    return box.center + Eigen::Rotation2Dd(box.yaw) * Eigen::Vector2d(x, y);
  };
  EXPECT_TRUE(box.contains(at(1.9, 0.9)));
  EXPECT_FALSE(box.contains(at(2.1, 0.0)));
  EXPECT_FALSE(box.contains(at(0.0, -1.1)));
  EXPECT_TRUE(box.contains(at(2.1, -1.1), 0.2));
}

}  // namespace
}  // namespace kestrel
