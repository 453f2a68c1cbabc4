// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/lidar/cloud_objects.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kestrel {
namespace {

/// A lidar at the origin, an upright surface at x = 10 m of this width, and a wall far behind it.
struct Scene {
  explicit Scene(double width) {
    for (double azimuth = -1.0; azimuth < 1.0; azimuth += 0.003) {
      for (double slope = -0.15; slope < 0.1; slope += 0.01) {
        const double y = 10.0 * std::tan(azimuth);
        const bool hits = std::abs(y) < 0.5 * width && std::abs(10.0 * slope) < 0.8;
        const double x = hits ? 10.0 : 40.0;
        const Eigen::Vector3d point(x, x * std::tan(azimuth), x * slope);
        points.push_back(point.cast<float>());
        if (hits) voxels.push_back({0, point, {points.back()}, true, true});
      }
    }
  }

  CloudObject objectOf(const KnownShape& known) const {
    const LidarView view(points, Eigen::Isometry3d::Identity());
    const auto objects = findCloudObjects(voxels, view, CloudTrackerConfig(),
                                          [&](const Eigen::Vector2d&) { return known; });
    EXPECT_EQ(objects.size(), 1U);
    return objects.at(0);
  }

  std::vector<Eigen::Vector3f> points;
  std::vector<MovingVoxel> voxels;
};

KnownShape vehicle(double yaw) {
  KnownShape shape;
  shape.length = 5.0;
  shape.width = 1.8;
  shape.yaw = yaw;
  return shape;
}

TEST(CloudObjectsTest, TheVehicleBehindItsVisibleRearIsCompleted) {
  const CloudObject object = Scene(1.8).objectOf(vehicle(0.0));
  EXPECT_FALSE(object.refutes_shape);
  EXPECT_NEAR(object.box.size.x(), 5.0, 0.05);
  EXPECT_NEAR(object.box.center.x(), 12.5, 0.05);
}

// A pedestrian who had been one cluster with a van kept its size: the middle of the track was 2 m
// beside.
TEST(CloudObjectsTest, APersonIsNoVehicleWhereBeamsPassAtBothSides) {
  for (const double yaw : {0.0, 0.5 * M_PI, 0.8}) {
    KnownShape known = vehicle(yaw);
    known.center = {10.0, 1.0};
    const CloudObject object = Scene(0.5).objectOf(known);
    EXPECT_TRUE(object.refutes_shape) << yaw;
    EXPECT_LT(object.box.size.maxCoeff(), 0.8) << yaw;
    EXPECT_LT((object.box.center - Eigen::Vector2d(10.0, 0.0)).norm(), 0.4) << yaw;
  }
}

/// The front of a vehicle at x = 30 m that comes towards the lidar at the origin, and what else is
/// seen at these distances along the line of its side.
std::vector<CloudObject> comingVehicle(const std::vector<double>& along_side) {
  std::vector<MovingVoxel> voxels;
  const auto add = [&](double x, double y) {
    const Eigen::Vector3d center(x, y, -0.8);
    voxels.push_back({0, center, {5, center.cast<float>()}, true, true});
  };
  for (double y = 2.0; y < 3.8; y += 0.4) add(30.0, y);
  for (const double x : along_side) add(x, 1.95);
  std::vector<Eigen::Vector3f> points;
  for (const MovingVoxel& voxel : voxels) points.push_back(voxel.points.front());
  KnownShape known;
  known.yaw = M_PI;
  return findCloudObjects(voxels, LidarView(points, Eigen::Isometry3d::Identity()),
                          CloudTrackerConfig(), [&](const Eigen::Vector2d&) { return known; });
}

// Before, the side of a vehicle that comes was tracked as other objects.
TEST(CloudObjectsTest, TheReturnsAlongTheSideOfAVehicleAreAPartOfIt) {
  const auto objects = comingVehicle({31.4, 32.8, 34.1, 35.2});
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_NEAR(objects[0].length, 5.2, 0.01);
  EXPECT_NEAR(objects[0].box.center.x(), 32.6, 0.01);
}

TEST(CloudObjectsTest, AVehicleBehindAnotherIsNoPartOfIt) {
  EXPECT_EQ(comingVehicle({37.0}).size(), 2U);
}

}  // namespace
}  // namespace kestrel
