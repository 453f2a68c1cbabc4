// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/lidar/cloud_icp.h"
#include "kestrel_slam/lidar/ground.h"
#include "kestrel_slam/lidar/surface_map.h"
#include "kestrel_slam/lidar/visitation.h"
#include "kestrel_slam/lidar/voxels.h"

namespace kestrel {
namespace {

using Points = std::vector<Eigen::Vector3f>;

/// A floor at -1.7 m + slope * x, and a wall at x = 15 m.
Points roomPoints(float slope, int density = 1) {
  Random random(1);
  Points points;
  for (int i = 0; i < 6000 * density; ++i) {
    const auto x = static_cast<float>(random.uniform(-20.0, 14.0));
    const auto y = static_cast<float>(random.uniform(-20.0, 20.0));
    points.emplace_back(x, y, -1.7F + slope * x + static_cast<float>(0.02 * random.gaussian()));
  }
  for (int i = 0; i < 3000 * density; ++i) {
    points.emplace_back(15.0F + static_cast<float>(0.02 * random.gaussian()),
                        static_cast<float>(random.uniform(-15.0, 15.0)),
                        static_cast<float>(random.uniform(-1.0, 4.0)));
  }
  return points;
}

TEST(GroundTest, IsRemovedInFourQuadrantsUpToTenInches) {
  Points points = roomPoints(0.05F);
  points.emplace_back(5.0F, 5.0F, -1.7F + 0.25F + 0.2F);   // 0.20 m above the floor
  points.emplace_back(5.0F, 5.0F, -1.7F + 0.25F + 0.30F);  // 0.30 m
  const Ground ground = findGround(points);
  for (const auto& plane : ground.planes) {
    ASSERT_TRUE(plane);
    EXPECT_NEAR(plane->normal.x() / plane->normal.z(), -0.05, 0.005);
  }
  const auto floor = std::count(ground.is_ground.begin(), ground.is_ground.begin() + 6000, true);
  EXPECT_EQ(floor, 6000);
  EXPECT_TRUE(ground.is_ground[points.size() - 2]);
  EXPECT_FALSE(ground.is_ground[points.size() - 1]);
}

TEST(GroundTest, APlaneSteeperThan30DegreesIsNoGround) {
  const Ground ground = findGround(roomPoints(0.7F));
  EXPECT_EQ(std::count(ground.is_ground.begin(), ground.is_ground.end(), true), 0);
}

TEST(GroundTest, WallsWithoutFloorKeepTheirPoints) {
  Points points = roomPoints(0.0F);
  points.erase(points.begin(), points.begin() + 6000);
  const Ground ground = findGround(points);
  EXPECT_EQ(std::count(ground.is_ground.begin(), ground.is_ground.end(), true), 0);
}

TEST(VoxelsTest, CentroidsAndSpreadEqualTheDirectSums) {
  const Points points = roomPoints(0.0F);
  const Voxels voxels = voxelize(points, {}, 0.5);
  std::vector<Eigen::Vector3d> sums(voxels.index.size(), Eigen::Vector3d::Zero());
  std::vector<double> counts(voxels.index.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(voxelIndexOf(points[i], 0.5), voxels.index[voxels.voxel_of[i]]);
    sums[voxels.voxel_of[i]] += points[i].cast<double>();
    counts[voxels.voxel_of[i]] += 1.0;
  }
  for (std::size_t v = 0; v < sums.size(); ++v) {
    EXPECT_EQ(voxels.sums[v].count, counts[v]);
    EXPECT_LT((voxels.sums[v].mean - sums[v] / counts[v]).norm(), 1e-9);
  }
}

TEST(SurfaceMapTest, ForgetsWhatIsFarSoThatTheMemoryIsBounded) {
  SurfaceMap map(0.5);
  std::size_t most = 0;
  for (int i = 0; i < 200; ++i) {  // 2 km
    Points points = roomPoints(0.0F);
    const Eigen::Vector3d at(10.0 * i, 0.0, 0.0);
    for (Eigen::Vector3f& point : points) point += at.cast<float>();
    map.add(voxelize(points, {}, 0.5), at);
    map.forgetFar(at, 100.0);
    most = std::max(most, map.cells().size());
    if (i == 40) most = map.cells().size();
  }
  EXPECT_LT(map.cells().size(), most + most / 10);
  for (const SurfaceCell& cell : map.cells()) EXPECT_GT(cell.mean.x(), 1880.0F);
}

/// Rings of a lidar at the origin on a wall at y = 10 m, with the noise of the range.
Points ringsOnAWall(const std::vector<double>& elevations_deg) {
  Random random(5);
  Points points;
  for (const double elevation : elevations_deg) {
    const double rise = std::tan(elevation * M_PI / 180.0);
    for (double azimuth = 1.0; azimuth < 2.1; azimuth += 0.0035) {
      const double range = 10.0 / std::sin(azimuth) + 0.02 * random.gaussian();
      points.emplace_back(static_cast<float>(range * std::cos(azimuth)),
                          static_cast<float>(range * std::sin(azimuth)),
                          static_cast<float>(range * rise));
    }
  }
  return points;
}

TEST(SurfaceMapTest, TheNoiseAlongTheBeamsOfARingIsNoPlane) {
  SurfaceMap map(0.5);
  map.add(voxelize(ringsOnAWall({-5.0}), {}, 0.5), Eigen::Vector3d::Zero());
  for (const SurfaceCell& cell : map.cells()) EXPECT_TRUE(cell.normal.isZero());
}

TEST(SurfaceMapTest, ASliceOfAHedgeAtTheEdgeOfTheViewIsNoPlane) {
  Random random(6);
  Points points;
  for (double azimuth = 1.0; azimuth < 2.1; azimuth += 0.001) {
    const double range = random.uniform(10.0, 10.5);  // the beams end at different depths
    const Eigen::Vector2d at = range * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
    points.push_back(Eigen::Vector3d(at.x(), at.y(), random.uniform(0.05, 0.13)).cast<float>());
  }
  SurfaceMap map(0.5);
  map.add(voxelize(points, {}, 0.5), Eigen::Vector3d::Zero());
  std::size_t planes = 0;
  for (const SurfaceCell& cell : map.cells()) planes += cell.normal.isZero() ? 0U : 1U;
  EXPECT_LT(planes, map.cells().size() / 4);
}

/// Flat ground 30 m from the lidar, with noise of this size along the normal.
SurfaceCell distantGround(double noise_m) {
  Random random(7);
  Points points;
  for (int i = 0; i < 300; ++i) {
    points.push_back(Eigen::Vector3d(random.uniform(30.05, 30.45), random.uniform(0.05, 0.45),
                                     -1.8 + noise_m * random.gaussian())
                         .cast<float>());
  }
  SurfaceMap map(0.5);
  map.add(voxelize(points, {}, 0.5), Eigen::Vector3d::Zero());
  return map.cells().front();
}

// Its plane is nearly along the beams, but thin: the beams cannot have made it.
TEST(SurfaceMapTest, DistantGroundIsAPlaneThatIsTheLessSureTheThickerItIs) {
  const SurfaceCell thin = distantGround(0.003), thick = distantGround(0.02);
  EXPECT_GT(std::min(std::abs(thin.normal.z()), std::abs(thick.normal.z())), 0.98F);
  EXPECT_LT(thin.tilt.norm(), 0.1F);
  EXPECT_GT(std::abs(thick.tilt.x()), 0.3F);  // towards the lidar
}

TEST(SurfaceMapTest, RingsInNeighboringVoxelsMakeThePlaneOfTheWall) {
  SurfaceMap map(0.5);
  map.add(voxelize(ringsOnAWall({-7.0, -5.0, -3.0, -1.0, 1.0, 3.0}), {}, 0.5),
          Eigen::Vector3d::Zero());
  std::size_t planes = 0;
  for (const SurfaceCell& cell : map.cells()) {
    if (cell.normal.isZero()) continue;
    ++planes;
    EXPECT_GT(std::abs(cell.normal.y()), 0.98F);
  }
  EXPECT_GT(planes, map.cells().size() / 2);
}

TEST(SurfaceMapTest, ARingOnTheGroundHasTheSlopeOfTheGround) {
  Points points;
  for (const float radius : {7.0F, 9.0F, 12.0F}) {
    for (double azimuth = 0.0; azimuth < 2.0 * M_PI; azimuth += 0.0035) {
      const float x = radius * static_cast<float>(std::cos(azimuth));
      points.emplace_back(x, radius * static_cast<float>(std::sin(azimuth)), -1.7F + 0.1F * x);
    }
  }
  const Ground ground = findGround(points);
  const Eigen::Isometry3d turned(Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitZ()));
  for (Eigen::Vector3f& point : points) point = turned.cast<float>() * point;
  const Voxels voxels = voxelize(points, {}, 0.5);
  SurfaceMap map(0.5);
  map.add(voxels, Eigen::Vector3d::Zero(), groundNormals(ground, voxels, turned));
  ASSERT_FALSE(map.cells().empty());
  const Eigen::Vector3f slope = Eigen::Vector3f(0.0F, -0.1F, 1.0F).normalized();
  for (const SurfaceCell& cell : map.cells()) EXPECT_GT(cell.normal.dot(slope), 0.999F);
}

TEST(GroundTest, WhatIsFlatInOneQuadrantAloneGivesNoNormals) {
  Points points;
  for (const float radius : {7.0F, 9.0F, 12.0F}) {
    for (double azimuth = 0.2; azimuth < 1.4; azimuth += 0.0035) {
      points.emplace_back(radius * static_cast<float>(std::cos(azimuth)),
                          radius * static_cast<float>(std::sin(azimuth)), -1.7F);
    }
  }
  const Ground ground = findGround(points);
  ASSERT_EQ(std::count(ground.is_ground.begin(), ground.is_ground.end(), true), points.size());
  const Voxels voxels = voxelize(points, {}, 0.5);
  for (const Eigen::Vector3f& normal :
       groundNormals(ground, voxels, Eigen::Isometry3d::Identity())) {
    EXPECT_TRUE(normal.isZero());
  }
}

/// Floor and three walls, as cells of a map with normals.
SurfaceMap boxMap() {
  Points points = roomPoints(0.0F, 12);
  Random random(2);
  for (int i = 0; i < 30000; ++i) {
    points.emplace_back(static_cast<float>(random.uniform(-20.0, 14.0)), i % 2 == 0 ? 12.0F : -9.0F,
                        static_cast<float>(random.uniform(-1.0, 4.0)));
  }
  SurfaceMap map(0.5);
  map.add(voxelize(points, {}, 0.5), Eigen::Vector3d::Zero());
  return map;
}

std::vector<Eigen::Vector3d> seenFrom(const SurfaceMap& map, const Eigen::Isometry3d& pose) {
  std::vector<Eigen::Vector3d> points;
  for (const SurfaceCell& cell : map.cells()) {
    points.push_back(pose.inverse() * cell.mean.cast<double>());
  }
  return points;
}

Eigen::Isometry3d somePose() {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << 0.12, -0.08, 0.05;
  pose.linear() = (Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(-0.006, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(0.005, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

TEST(CloudIcpTest, FindsAllSixDegreesWithBothMetrics) {
  const SurfaceMap map = boxMap();
  const Eigen::Isometry3d truth = somePose();
  for (const IcpMetric metric : {IcpMetric::kPoint, IcpMetric::kPlane}) {
    CloudIcpConfig config;
    config.metric = metric;
    config.max_iterations = 50;
    const CloudIcpResult result =
        CloudIcp(map.cells(), config).align(seenFrom(map, truth), Eigen::Isometry3d::Identity());
    EXPECT_TRUE(result.converged);
    EXPECT_LT((result.pose.translation() - truth.translation()).norm(), 2e-3);
    EXPECT_LT(Eigen::AngleAxisd(result.pose.linear().transpose() * truth.linear()).angle(), 3e-4);
  }
}

TEST(CloudIcpTest, WorstTenPercentOfThePairsAreRejected) {
  const SurfaceMap map = boxMap();
  const Eigen::Isometry3d truth = somePose();
  std::vector<Eigen::Vector3d> points = seenFrom(map, truth);
  CloudIcpConfig config;
  config.max_points = points.size();
  for (std::size_t i = 0; i < points.size(); i += 16) points[i] += Eigen::Vector3d(0.3, 0.3, 0.3);
  const auto errorOf = [&](double share) {
    config.rejected_share = share;
    const CloudIcpResult result =
        CloudIcp(map.cells(), config).align(points, Eigen::Isometry3d::Identity());
    return (result.pose.translation() - truth.translation()).norm();
  };
  EXPECT_LT(errorOf(0.1), 0.5 * errorOf(0.0));
}

TEST(CloudIcpTest, WhatDoesNotFitLosesItsWeight) {
  const SurfaceMap map = boxMap();
  std::vector<Eigen::Vector3d> points = seenFrom(map, Eigen::Isometry3d::Identity());
  Random random(6);
  for (std::size_t i = 0; i < points.size(); i += 3) {  // leaves before the walls
    points[i] -= random.uniform(0.2, 0.6) * Eigen::Vector3d(1.0, 0.0, 0.0);
  }
  const CloudIcpResult result = CloudIcp(map.cells()).align(points, Eigen::Isometry3d::Identity());
  EXPECT_LT(result.pose.translation().norm(), 0.01);
}

TEST(CloudIcpTest, FewPointsOnAWallAreNotLostAmongThoseOfTheFloor) {
  const SurfaceMap map = boxMap();
  std::vector<Eigen::Vector3d> points;
  Random random(7);
  for (int i = 0; i < 30000; ++i) {
    points.emplace_back(random.uniform(-18.0, 12.0), random.uniform(-8.0, 11.0), -1.7);
  }
  for (int i = 0; i < 400; ++i) {
    points.emplace_back(15.0 + 0.05 * random.gaussian(), random.uniform(-8.0, 11.0),
                        random.uniform(-0.9, 3.9));
  }
  const CloudIcpResult result = CloudIcp(map.cells()).align(points, Eigen::Isometry3d::Identity());
  EXPECT_LT(std::abs(result.pose.translation().x()), 0.01);
}

// Half of the planes show another height. They may be turned, so the others say where the lidar is.
TEST(CloudIcpTest, PlanesThatMayBeTurnedSayLittle) {
  std::vector<SurfaceCell> cells;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 400; ++i) {
    SurfaceCell cell;
    const float turned = i % 2 == 0 ? 0.0F : 1.0F;
    cell.mean << static_cast<float>(i % 20) - 9.75F, static_cast<float>(i / 20) - 9.75F, -1.7F;
    points.emplace_back((cell.mean + Eigen::Vector3f(0.25F, 0.0F, 0.0F)).cast<double>());
    cell.normal = Eigen::Vector3f::UnitZ();
    cell.tilt.x() = 0.7F * turned;
    cell.mean.z() += 0.05F * turned;
    cells.push_back(cell);
  }
  const CloudIcpResult result = CloudIcp(cells).align(points, Eigen::Isometry3d::Identity());
  EXPECT_LT(std::abs(result.pose.translation().z()), 0.008);
}

TEST(CloudIcpTest, ADirectionWithoutSurfacesKeepsTheGuess) {
  Points points;
  Random random(3);
  for (int i = 0; i < 80000; ++i) {  // only a floor: x, y and yaw are not observable
    points.emplace_back(static_cast<float>(random.uniform(-20.0, 20.0)),
                        static_cast<float>(random.uniform(-20.0, 20.0)), -1.7F);
  }
  SurfaceMap map(0.5);
  map.add(voxelize(points, {}, 0.5), Eigen::Vector3d::Zero());
  Eigen::Isometry3d guess = Eigen::Isometry3d::Identity();
  guess.translation() << 0.3, 0.2, 0.1;
  const CloudIcpResult result =
      CloudIcp(map.cells()).align(seenFrom(map, Eigen::Isometry3d::Identity()), guess);
  EXPECT_NEAR(result.pose.translation().x(), 0.3, 0.01);
  EXPECT_NEAR(result.pose.translation().y(), 0.2, 0.01);
  EXPECT_NEAR(result.pose.translation().z(), 0.0, 0.01);
}

TEST(VisitationTest, FindsTheGapThroughWhichBeamsWentWithoutReturn) {
  // Rings around the lidar hit a wall at 15 m, except between 20 and 40 degrees of azimuth.
  Points points;
  for (int ring = -10; ring <= 10; ++ring) {
    for (int i = 0; i < 1440; ++i) {
      const double azimuth = i * 0.25 * M_PI / 180.0, degrees = i * 0.25;
      if (degrees > 20.0 && degrees < 40.0 && ring != 10 && ring != -10) continue;
      points.emplace_back(static_cast<float>(15.0 * std::cos(azimuth)),
                          static_cast<float>(15.0 * std::sin(azimuth)),
                          static_cast<float>(15.0 * std::tan(ring * 1.33 * M_PI / 180.0)));
    }
  }
  VisitationConfig config;
  const auto cells = unvisitedCells(points, Ground(), Eigen::Isometry3d::Identity(), config);
  ASSERT_GT(cells.size(), 100U);
  for (const GridIndex<3>& cell : cells) {
    const double azimuth = std::atan2(cell.y() + 0.5, cell.x() + 0.5) * 180.0 / M_PI;
    EXPECT_GT(azimuth, 15.0);
    EXPECT_LT(azimuth, 45.0);
  }
}

}  // namespace
}  // namespace kestrel
