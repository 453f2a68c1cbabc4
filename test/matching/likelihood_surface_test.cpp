// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/likelihood_surface.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

const Points& scanOfTheRoom() {
  static const Points points = hitsOf(room::scanFrom(Pose2(0.2, -0.1, 0.3)));
  return points;
}

TEST(LikelihoodSurface, ItsMaximumIsTheResultOfTheSearch) {
  const Submap map = room::map();
  CorrelativeConfig config;
  config.linear_preference = config.angular_preference = 0.0;
  const Pose2 center(0.3, -0.2, 0.35);
  const SearchWindow window{0.4, 0.2};
  const LikelihoodSurface surface =
      sampleLikelihood(map.surface(), scanOfTheRoom(), center, window, config);
  const SearchResult found = searchWindow(map.surface(), scanOfTheRoom(), center, window, config);
  EXPECT_EQ(surface.side(), 17);
  EXPECT_EQ(surface.score.size(),
            17U * 17U * static_cast<std::size_t>(2 * surface.angular_steps + 1));
  const auto best = std::max_element(surface.score.begin(), surface.score.end());
  EXPECT_FLOAT_EQ(*best, static_cast<float>(found.score));
  const int dx = static_cast<int>(std::lround((found.pose.x - center.x) / surface.step_m));
  const int dy = static_cast<int>(std::lround((found.pose.y - center.y) / surface.step_m));
  const int k = static_cast<int>(std::lround((found.pose.yaw - center.yaw) / surface.step_rad));
  EXPECT_EQ(surface.at(dx, dy, k), *best);
  EXPECT_NEAR((surface.pose(dx, dy, k).inverse() * found.pose).distance(), 0.0, 1e-9);
  const std::vector<float> image = bestOverYaws(surface);
  ASSERT_EQ(image.size(), 17U * 17U);
  EXPECT_EQ(image[static_cast<std::size_t>((dy + 8) * 17 + dx + 8)], *best);
  EXPECT_EQ(*std::max_element(image.begin(), image.end()), *best);
}

/// One post in the center of cell (0, 0): the score is the likelihood of the distance.
TEST(LikelihoodSurface, IsTheLikelihoodOfTheDistanceForOnePost) {
  Submap map{OccupancyGridConfig()};
  PlanarScan scan;
  const Eigen::Vector2f middle(0.025F, 0.025F);
  scan.rays.push_back({middle, middle, true});
  map.insert(scan, Pose2());
  const LikelihoodSurface surface =
      sampleLikelihood(map.surface(), {middle}, Pose2(), {0.25, 0.0}, CorrelativeConfig());
  ASSERT_EQ(surface.linear_steps, 5);
  for (int dy = -5; dy <= 5; ++dy) {
    for (int dx = -5; dx <= 5; ++dx) {
      const double distance2 = 0.05 * 0.05 * (dx * dx + dy * dy);
      EXPECT_NEAR(surface.at(dx, dy, 0), std::exp(-0.5 * distance2 / (0.1 * 0.1)),
                  0.5 / 255 + 1e-4);
    }
  }
}

/// Compares with the mean over the points, computed from the surfels without an image.
TEST(LikelihoodSurface, IsTheMeanLikelihoodOfThePoints) {
  const Submap map = room::map();
  const Points& points = scanOfTheRoom();
  const CorrelativeConfig config;
  const LikelihoodSurface surface =
      sampleLikelihood(map.surface(), points, Pose2(0.3, -0.2, 0.35), {0.6, 0.3}, config);
  for (int k = -surface.angular_steps; k <= surface.angular_steps; k += 7) {
    for (int dy = -surface.linear_steps; dy <= surface.linear_steps; dy += 4) {
      for (int dx = -surface.linear_steps; dx <= surface.linear_steps; dx += 3) {
        double sum = 0.0;
        for (const Eigen::Vector2f& point : points) {
          const Eigen::Vector2d at = surface.pose(dx, dy, k) * point.cast<double>();
          const Eigen::Vector2f middle =
              (at / surface.step_m).array().floor().cast<float>() * 0.05F + 0.025F;
          const Surfel* surfel = map.surface().nearest(middle);
          if (surfel == nullptr) continue;
          const double distance = static_cast<double>((middle - surfel->mean).norm());
          sum += std::exp(-0.5 * distance * distance / (config.sigma_m * config.sigma_m));
        }
        ASSERT_NEAR(surface.at(dx, dy, k), sum / static_cast<double>(points.size()), 0.005)
            << dx << " " << dy << " " << k;
      }
    }
  }
}

/// The likelihood exp(30 (score - 1)) of these scores is a Gaussian with known moments.
TEST(LikelihoodSurface, MomentsOfAGaussianAreItsParameters) {
  LikelihoodSurface surface;
  surface.center = Pose2(1.0, 2.0, 0.5);
  surface.step_m = 0.05;
  surface.step_rad = 0.01;
  surface.linear_steps = surface.angular_steps = 20;
  const Eigen::Vector3d mean(0.07, -0.04, 0.013);
  Eigen::Matrix3d covariance;
  covariance << 0.01, 0.004, 0.0005, 0.004, 0.02, -0.0003, 0.0005, -0.0003, 0.0004;
  const Eigen::Matrix3d information = covariance.inverse();
  for (int k = -20; k <= 20; ++k) {
    for (int dy = -20; dy <= 20; ++dy) {
      for (int dx = -20; dx <= 20; ++dx) {
        const Eigen::Vector3d d = Eigen::Vector3d(0.05 * dx, 0.05 * dy, 0.01 * k) - mean;
        surface.score.push_back(static_cast<float>(1.0 - d.dot(information * d) / 60.0));
      }
    }
  }
  const PoseMoments moments = momentsOf(surface);
  EXPECT_NEAR(moments.mean.x, 1.07, 1e-4);
  EXPECT_NEAR(moments.mean.y, 1.96, 1e-4);
  EXPECT_NEAR(moments.mean.yaw, 0.513, 1e-4);
  EXPECT_TRUE(moments.covariance.isApprox(covariance, 1e-3)) << moments.covariance;
  EXPECT_LT(moments.linear_border, 1e-4);
  EXPECT_LT(moments.angular_border, 1e-4);
}

TEST(LikelihoodSurface, MomentsOfAConstantSurfaceAreThoseOfItsWindow) {
  LikelihoodSurface surface;
  surface.step_m = surface.step_rad = 1.0;
  surface.linear_steps = 1;
  surface.angular_steps = 2;
  surface.score.assign(9 * 5, 0.5F);
  const PoseMoments moments = momentsOf(surface);
  EXPECT_NEAR(moments.covariance(0, 0), 2.0 / 3.0, 1e-12);
  EXPECT_NEAR(moments.covariance(2, 2), 2.0, 1e-12);
  EXPECT_NEAR(moments.linear_border, 8.0 / 9.0, 1e-12);
  EXPECT_NEAR(moments.angular_border, 2.0 / 5.0, 1e-12);
}

TEST(LikelihoodSurface, IsEmptyWithoutPointsAndLimitsTheWindow) {
  const Submap map = room::map();
  const CorrelativeConfig config;
  EXPECT_TRUE(sampleLikelihood(map.surface(), {}, Pose2(), {0.5, 0.5}, config).score.empty());
  EXPECT_TRUE(bestOverYaws(LikelihoodSurface()).empty());
  EXPECT_THROW(sampleLikelihood(map.surface(), scanOfTheRoom(), Pose2(), {50.0, kPi}, config),
               std::invalid_argument);
}

/// In a corridor the surface is a ridge. The covariance uses the largest region that is allowed.
TEST(LikelihoodSurface, CovarianceFollowsTheRidgeOfACorridor) {
  Submap map{OccupancyGridConfig()};
  for (const double x : {0.0, 0.8}) {
    map.insert(room::scanFrom(Pose2(), room::corridor()), Pose2(x, 0, 0));
  }
  const Points points = hitsOf(room::scanFrom(Pose2(), room::corridor(), 180, 3.0));
  const Eigen::Matrix3d covariance =
      searchWindow(map.surface(), points, Pose2(0.4, 0, 0), {0.3, 0.1}, CorrelativeConfig())
          .covariance;
  // A constant likelihood over ±12 cells of 5 cm: variance (25² - 1) / 12 cells².
  EXPECT_NEAR(std::sqrt(covariance(0, 0)), 0.05 * std::sqrt(52.0), 0.02);
  EXPECT_LT(std::sqrt(covariance(1, 1)), 0.08);
}

}  // namespace
}  // namespace kestrel
