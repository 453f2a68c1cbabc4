// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kStamp = 50.0;
constexpr double kRadius = 6.0;  // of the round room, m
constexpr double kHeight = 1.2;  // of the lidar over the floor, m

/// The cloud of a lidar with 16 rings in a round room with infinitely high walls, column by column.
/// The lidar turns about the vertical at `yaw_rate` (rad/s) during the sweep.
PointCloud scanRoundRoom(const Quaterniond& orientation, double yaw_rate) {
  PointCloud cloud;
  cloud.stamp = kStamp;
  for (int column = 0; column < 720; ++column) {
    const double time = column * 0.1 / 720.0;
    const Quaterniond world_R_lidar = AngleAxisd(yaw_rate * time, Vector3d::UnitZ()) * orientation;
    for (int ring = 0; ring < 16; ++ring) {
      const double azimuth = degToRad(0.5 * column), elevation = degToRad(-15.0 + 2.0 * ring);
      const Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                         std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const Vector3d d = world_R_lidar * ray;
      double range = kRadius / d.head<2>().norm();
      if (d.z() < 0.0) range = std::min(range, -kHeight / d.z());
      const Eigen::Vector3f p = (range * ray).cast<float>();
      cloud.points.push_back({p.x(), p.y(), p.z(), static_cast<float>(time)});
    }
  }
  return cloud;
}

AttitudeBuffer attitudeOf(const Quaterniond& orientation, double yaw_rate) {
  AttitudeBuffer buffer;
  for (int i = -10; i < 30; ++i) {
    const double t = 0.01 * i;
    const Quaterniond q = AngleAxisd(yaw_rate * t, Vector3d::UnitZ()) * orientation;
    buffer.add(kStamp + t, q, q.inverse() * Vector3d(0.0, 0.0, yaw_rate));
  }
  return buffer;
}

Projection projectCloud(const PointCloud& cloud, const AttitudeBuffer* attitude) {
  VehicleState vehicle;
  vehicle.attitude = attitude;
  vehicle.height_m = kHeight;
  return ScanProjector(ProjectorConfig()).project(cloud, Isometry3d::Identity(), vehicle);
}

TEST(CloudProjector, SlicesARoomFromATiltedAndTurningLidar) {
  const Quaterniond tilt(AngleAxisd(0.15, Vector3d(0.6, 0.8, 0.0)));
  const AttitudeBuffer attitude = attitudeOf(tilt, 1.5);
  const Projection result = projectCloud(scanRoundRoom(tilt, 1.5), &attitude);
  ASSERT_EQ(result.error, ScanError::kNone) << result.message;
  EXPECT_GT(result.counts.hits, 600U);
  EXPECT_LE(result.scan.rays.size(), 1080U);
  EXPECT_GT(result.counts.floor, 100U);
  for (const PlanarRay& ray : result.scan.rays) {
    if (!ray.hit) continue;
    EXPECT_NEAR(ray.end.norm(), kRadius, 2e-3);
  }
}

TEST(CloudProjector, KeepsTheNearestReturnOfEveryDirection) {
  PointCloud cloud;
  cloud.stamp = kStamp;
  cloud.points = {
      {5.0F, 0.001F, 0.1F, 0.0F}, {3.0F, 0.001F, -0.2F, 0.0F}, {4.0F, 0.001F, 0.0F, 0.0F}};
  const Projection result = projectCloud(cloud, nullptr);
  ASSERT_EQ(result.scan.rays.size(), 1U);
  EXPECT_TRUE(result.scan.rays[0].hit);
  EXPECT_FLOAT_EQ(result.scan.rays[0].end.x(), 3.0F);
  EXPECT_FLOAT_EQ(result.scan.rays[0].end.y(), 0.001F);
}

TEST(CloudProjector, AReturnOutsideTheSliceClearsTheSpaceInsideIt) {
  PointCloud cloud;
  cloud.stamp = kStamp;
  cloud.points = {{4.0F, 0.001F, 3.0F, 0.0F}};  // leaves the slice (1.5 m high) after 2 m
  const Projection result = projectCloud(cloud, nullptr);
  ASSERT_EQ(result.scan.rays.size(), 1U);
  EXPECT_FALSE(result.scan.rays[0].hit);
  EXPECT_NEAR(result.scan.rays[0].end.x(), 2.0, 1e-5);
  EXPECT_EQ(result.counts.outside, 1U);
}

TEST(CloudProjector, CountsInvalidPointsAndRefusesInvalidClouds) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  PointCloud cloud;
  cloud.stamp = kStamp;
  EXPECT_EQ(projectCloud(cloud, nullptr).error, ScanError::kNoBeams);
  cloud.points = {{nan, 1.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 0.0F, 0.0F}};
  const Projection result = projectCloud(cloud, nullptr);
  EXPECT_EQ(result.error, ScanError::kNoValidBeam);
  EXPECT_EQ(result.counts.invalid, 2U);
  cloud.points = {{1.0F, 0.0F, 0.0F, 0.0F}, {1.0F, 0.0F, 0.0F, 1e6F}};  // µs instead of s
  EXPECT_EQ(projectCloud(cloud, nullptr).error, ScanError::kBadGeometry);
  cloud.points = {{1.0F, 0.0F, 0.0F, 0.0F}};
  cloud.stamp = std::numeric_limits<double>::infinity();
  EXPECT_EQ(projectCloud(cloud, nullptr).error, ScanError::kBadStamp);
}

}  // namespace
}  // namespace kestrel
