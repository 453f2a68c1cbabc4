// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kScanStamp = 100.0;
constexpr double kHalfRoom = 4.0;  // m; the room is a square around the origin
constexpr float kNothing = std::numeric_limits<float>::infinity();

using PoseAt = std::function<Isometry3d(double)>;

Quaterniond tilt(double roll, double pitch, double yaw = 0.0) {
  return AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
         AngleAxisd(roll, Vector3d::UnitX());
}

Isometry3d poseOf(const Vector3d& position, const Quaterniond& orientation) {
  Isometry3d pose = Isometry3d::Identity();
  pose.translate(position);
  pose.rotate(orientation);
  return pose;
}

/// Range to the nearest of the four infinitely high walls and the floor (z = 0), m.
double castInRoom(const Vector3d& origin, const Vector3d& direction) {
  double range = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 2; ++axis) {
    const double wall = direction[axis] > 0.0 ? kHalfRoom : -kHalfRoom;
    if (direction[axis] != 0.0) range = std::min(range, (wall - origin[axis]) / direction[axis]);
  }
  if (direction.z() < 0.0) range = std::min(range, -origin.z() / direction.z());
  return range;
}

/// The scan of a laser in the room, with each beam at its own time.
LaserScan scanRoom(const PoseAt& world_T_laser, double time_increment) {
  LaserScan scan;
  scan.stamp = kScanStamp;
  scan.angle_min = degToRad(-135.0);
  scan.angle_increment = degToRad(0.25);
  scan.time_increment = time_increment;
  scan.range_max = 30.0;
  for (int i = 0; i < 1081; ++i) {
    const double angle = scan.angle_min + i * scan.angle_increment;
    const Isometry3d pose = world_T_laser(kScanStamp + i * time_increment);
    const Vector3d direction = pose.linear() * Vector3d(std::cos(angle), std::sin(angle), 0.0);
    scan.ranges.push_back(static_cast<float>(castInRoom(pose.translation(), direction)));
  }
  return scan;
}

/// The readings of a perfect IMU at 200 Hz around the scan.
AttitudeBuffer imuOf(const PoseAt& world_T_base) {
  constexpr double kStep = 0.005, kDelta = 1e-5;
  AttitudeBuffer buffer;
  for (int i = -4; i <= 20; ++i) {
    const double t = kScanStamp + kStep * i;
    const Quaterniond before(world_T_base(t - kDelta).linear()),
        after(world_T_base(t + kDelta).linear());
    const AngleAxisd turn(before.inverse() * after);
    buffer.add(t, Quaterniond(world_T_base(t).linear()),
               Vector3d(turn.axis() * turn.angle() / (2.0 * kDelta)));
  }
  return buffer;
}

/// Largest distance of a hit from the walls if the scan is placed at the true pose, m.
double worstWallDistance(const PlanarScan& scan, const Isometry3d& world_T_base) {
  const double yaw = yawOf(Quaterniond(world_T_base.linear()));
  const Eigen::Rotation2Dd rotation(yaw);
  double worst = 0.0;
  for (const PlanarRay& ray : scan.rays) {
    if (!ray.hit) continue;
    const Eigen::Vector2d p =
        rotation * ray.end.cast<double>() + world_T_base.translation().head<2>();
    worst = std::max(worst, std::abs(p.cwiseAbs().maxCoeff() - kHalfRoom));
  }
  return worst;
}

const Isometry3d kMounting = poseOf(Vector3d(0.1, -0.05, 0.08), tilt(kPi, 0.0, 0.3));

TEST(TiltedProjection, ProjectsTheWallsOfATiltedLaserToTheirPositions) {
  const Isometry3d world_T_base = poseOf(Vector3d(0.5, -0.7, 1.0), tilt(0.17, -0.12, 0.6));
  const PoseAt base = [&](double) { return world_T_base; };
  const LaserScan scan = scanRoom([&](double t) { return base(t) * kMounting; }, 0.0);
  const AttitudeBuffer attitude = imuOf(base);
  VehicleState vehicle;
  vehicle.attitude = &attitude;
  vehicle.height_m = 1.0;
  ScanProjector projector{ProjectorConfig()};
  const Projection result = projector.project(scan, kMounting, vehicle);
  ASSERT_EQ(result.error, ScanError::kNone) << result.message;
  EXPECT_GT(result.counts.hits, 500U);
  EXPECT_LT(worstWallDistance(result.scan, world_T_base), 1e-4);
  EXPECT_NEAR(result.tilt_rad, tiltOf(tilt(0.17, -0.12)), 1e-9);

  // Without the attitude the walls are at wrong positions.
  const Projection level = projector.project(scan, kMounting);
  EXPECT_GT(worstWallDistance(level.scan, world_T_base), 0.05);
}

TEST(TiltedProjection, RotatesEveryBeamWithTheAttitudeAtItsOwnTime) {
  // 2 rad/s of yaw, 3 rad/s of roll and 1 m/s of translation during a sweep of 19 ms.
  const PoseAt base = [](double t) {
    const double s = t - kScanStamp;
    return poseOf(Vector3d(0.2 + 1.0 * s, -0.3 - 0.4 * s, 1.0), tilt(0.1 + 3.0 * s, 0.05, 2.0 * s));
  };
  constexpr double kTimeIncrement = 0.025 / 1440.0;
  const LaserScan scan = scanRoom([&](double t) { return base(t) * kMounting; }, kTimeIncrement);
  const AttitudeBuffer attitude = imuOf(base);
  VehicleState vehicle;
  vehicle.attitude = &attitude;
  vehicle.height_m = 1.0;
  vehicle.velocity = Eigen::Vector2d(1.0, -0.4);
  ScanProjector projector{ProjectorConfig()};
  const Projection result = projector.project(scan, kMounting, vehicle);
  ASSERT_EQ(result.error, ScanError::kNone) << result.message;
  EXPECT_GT(result.counts.hits, 500U);
  EXPECT_LT(worstWallDistance(result.scan, base(kScanStamp)), 1e-3);

  vehicle.velocity.setZero();
  EXPECT_GT(worstWallDistance(projector.project(scan, kMounting, vehicle).scan, base(kScanStamp)),
            0.01);
}

TEST(TiltedProjection, WithoutAnAttitudeRotatesEveryBeamWithTheYawRate) {
  constexpr double kYawRate = 2.0, kTimeIncrement = 0.025 / 1440.0;
  const PoseAt base = [&](double t) {
    return poseOf(Vector3d(0.2, -0.3, 1.0), tilt(0.0, 0.0, kYawRate * (t - kScanStamp)));
  };
  const LaserScan scan = scanRoom([&](double t) { return base(t) * kMounting; }, kTimeIncrement);
  ScanProjector projector{ProjectorConfig()};
  VehicleState vehicle;
  vehicle.yaw_rate = kYawRate;
  EXPECT_LT(worstWallDistance(projector.project(scan, kMounting, vehicle).scan, base(kScanStamp)),
            1e-3);
  EXPECT_GT(worstWallDistance(projector.project(scan, kMounting).scan, base(kScanStamp)), 0.05);
}

TEST(TiltedProjection, ReturnsFromTheFloorAreNotHitsButClear) {
  const Isometry3d world_T_base = poseOf(Vector3d(0.0, 0.0, 0.5), tilt(0.0, 0.25));
  const PoseAt base = [&](double) { return world_T_base; };
  const LaserScan scan = scanRoom(base, 0.0);
  const AttitudeBuffer attitude = imuOf(base);
  VehicleState vehicle;
  vehicle.attitude = &attitude;
  vehicle.height_m = 0.5;
  const Projection result =
      ScanProjector(ProjectorConfig()).project(scan, Isometry3d::Identity(), vehicle);
  EXPECT_GT(result.counts.floor, 100U);
  EXPECT_LT(worstWallDistance(result.scan, world_T_base), 1e-4);
  // The beam straight ahead hits the floor at 0.5 / tan(0.25). It leaves the slice 0.15 m above the
  // floor, and a little more for the error of the attitude.
  const double expected = (0.5 - 0.15) / (std::sin(0.25) + 0.0175) * std::cos(0.25);
  bool found = false;
  for (const PlanarRay& ray : result.scan.rays) {
    if (ray.hit || std::abs(ray.end.y()) > 1e-3F || ray.end.x() < 0.0F) continue;
    found = true;
    EXPECT_NEAR(ray.end.x(), expected, 1e-3);
  }
  EXPECT_TRUE(found);
}

/// Far away a small error of the attitude lifts the floor by more than the margin.
TEST(TiltedProjection, TheFloorIsLeftOutWithAWrongAttitude) {
  const Isometry3d world_T_base = poseOf(Vector3d(0.0, 0.0, 1.0), tilt(0.0, 0.25));
  const AttitudeBuffer attitude =
      imuOf([&](double) { return poseOf(Vector3d(0.0, 0.0, 1.0), tilt(0.0, 0.21)); });
  VehicleState vehicle;
  vehicle.attitude = &attitude;
  vehicle.height_m = 1.0;
  const Projection result = ScanProjector(ProjectorConfig())
                                .project(scanRoom([&](double) { return world_T_base; }, 0.0),
                                         Isometry3d::Identity(), vehicle);
  EXPECT_GT(result.counts.floor, 20U);
  EXPECT_LT(worstWallDistance(result.scan, world_T_base), 0.2);
}

TEST(TiltedProjection, LeavesOutReturnsAboveAndBelowTheSlice) {
  ProjectorConfig config;
  config.slice_min_m = -0.2;
  config.slice_max_m = 0.3;
  const Isometry3d world_T_base = poseOf(Vector3d(0.0, 0.0, 5.0), tilt(0.0, 0.1));
  const PoseAt base = [&](double) { return world_T_base; };
  const AttitudeBuffer attitude = imuOf(base);
  VehicleState vehicle;
  vehicle.attitude = &attitude;
  const Projection result =
      ScanProjector(config).project(scanRoom(base, 0.0), Isometry3d::Identity(), vehicle);
  // Ahead the returns are 4 m · tan(0.1) = 0.40 m below, behind 0.40 m above: outside of the slice.
  EXPECT_GT(result.counts.outside, 300U);
  for (const PlanarRay& ray : result.scan.rays) {
    const double below = ray.end.x() * std::tan(0.1);
    EXPECT_LE(below, 0.2 + 1e-4);
    EXPECT_GE(below, -0.3 - 1e-4);
  }
}

TEST(TiltedProjection, RefusesAScanBeyondTheTiltLimitOrWithoutAttitude) {
  const PoseAt base = [](double) { return poseOf(Vector3d(0, 0, 1), tilt(0.7, 0.0)); };
  const LaserScan scan = scanRoom(base, 0.0);
  AttitudeBuffer attitude = imuOf(base);
  VehicleState vehicle;
  vehicle.attitude = &attitude;
  ScanProjector projector{ProjectorConfig()};
  const Projection tilted = projector.project(scan, Isometry3d::Identity(), vehicle);
  EXPECT_EQ(tilted.error, ScanError::kTilted);
  EXPECT_NE(tilted.message.find("40.1 deg"), std::string::npos) << tilted.message;
  attitude.clear();
  EXPECT_EQ(projector.project(scan, Isometry3d::Identity(), vehicle).error, ScanError::kNoAttitude);
}

TEST(TiltedProjection, MeasuresTheHeightWithAMirror) {
  ProjectorConfig config;
  config.mirror_angles = "120:135";
  config.mirror_distance_m = 0.08;
  LaserScan scan;
  scan.stamp = kScanStamp;
  scan.angle_min = degToRad(-135.0);
  scan.angle_increment = degToRad(0.25);
  scan.range_max = 30.0;
  const Quaterniond orientation = tilt(0.1, 0.2);
  const Isometry3d mounting = poseOf(Vector3d(0.02, 0.0, 0.1), Quaterniond::Identity());
  for (int i = 0; i < 1081; ++i) {
    const double angle = scan.angle_min + i * scan.angle_increment;
    const Vector3d mirror =
        orientation * (mounting * (0.08 * Vector3d(std::cos(angle), std::sin(angle), 0.0)));
    const Vector3d down = orientation * -Vector3d::UnitZ();
    // The base is 1.3 m above the floor.
    const double range = 0.08 + (1.3 + mirror.z()) / -down.z();
    scan.ranges.push_back(angle >= degToRad(120.0) - 1e-9 ? static_cast<float>(range) : 3.0F);
  }
  AttitudeBuffer attitude = imuOf([&](double) { return poseOf(Vector3d::Zero(), orientation); });
  VehicleState vehicle;
  vehicle.attitude = &attitude;
  const Projection result = ScanProjector(config).project(scan, mounting, vehicle);
  ASSERT_TRUE(result.mirror_height_m);
  EXPECT_NEAR(*result.mirror_height_m, 1.3, 1e-3);
  EXPECT_EQ(result.counts.masked, 61U);
}

/// The heights over the floor that the projector finds while the pitch grows from 3 to 9 degrees.
std::vector<double> floorHeights(double height, double x) {
  ScanProjector projector{ProjectorConfig()};
  std::vector<double> heights;
  for (int i = 0; i < 20; ++i) {
    const PoseAt base = [&](double) {
      return poseOf(Vector3d(x, 0.0, height), tilt(0.0, degToRad(3.0 + 0.3 * i)));
    };
    LaserScan scan = scanRoom(base, 0.0);
    AttitudeBuffer attitude;
    for (const double time : {0.025 * i, 0.025 * i + 0.01}) {
      attitude.add(kScanStamp + time, Quaterniond(base(0.0).linear()), Vector3d::Zero());
    }
    scan.stamp = kScanStamp + 0.025 * i;
    VehicleState vehicle;
    vehicle.attitude = &attitude;
    const Projection result = projector.project(scan, Isometry3d::Identity(), vehicle);
    if (result.floor_height_m) heights.push_back(*result.floor_height_m);
  }
  return heights;
}

TEST(TiltedProjection, FindsTheHeightOverTheFloorFromItsReturns) {
  const std::vector<double> heights = floorHeights(0.5, -3.8);
  ASSERT_GT(heights.size(), 3U);
  for (const double height : heights) EXPECT_NEAR(height, 0.5, 0.02);
}

TEST(TiltedProjection, AWallAheadIsNotTakenForTheFloor) {
  EXPECT_TRUE(floorHeights(50.0, 1.0).empty());
}

TEST(TiltedProjection, LeavesOutMixedPixelsButKeepsWallsAtAGrazingAngle) {
  LaserScan scan;
  scan.stamp = kScanStamp;
  scan.angle_min = 0.0;
  scan.angle_increment = degToRad(0.25);
  scan.range_max = 30.0;
  scan.ranges = {2.0F, 2.0F, 2.0F, 3.1F, 5.0F, 5.0F, 5.0F};
  EXPECT_EQ(ScanProjector(ProjectorConfig()).project(scan, Isometry3d::Identity()).counts.mixed,
            1U);

  scan.ranges.clear();
  for (int i = 0; i < 400; ++i) {  // a wall 1 m to the left, at a grazing angle
    scan.ranges.push_back(static_cast<float>(1.0 / std::sin(0.05 + i * scan.angle_increment)));
  }
  const Projection wall = ScanProjector(ProjectorConfig()).project(scan, Isometry3d::Identity());
  EXPECT_EQ(wall.counts.mixed, 0U);
  EXPECT_EQ(wall.counts.hits, 400U);
}

TEST(TiltedProjection, MasksTheVehiclesFrame) {
  ProjectorConfig config;
  config.ignored_angles = "-135:-110, 110:135";
  config.vehicle_radius_m = 0.3;
  LaserScan scan;
  scan.stamp = kScanStamp;
  scan.angle_min = degToRad(-135.0);
  scan.angle_increment = degToRad(1.0);
  scan.range_max = 30.0;
  scan.ranges.assign(271, 2.0F);
  scan.ranges[135] = 0.25F;
  const Projection result = ScanProjector(config).project(scan, Isometry3d::Identity());
  EXPECT_EQ(result.counts.masked, 26U + 26U + 1U);
  EXPECT_EQ(result.counts.hits, 271U - 53U);
  EXPECT_THROW(parseAngleRanges("10"), std::invalid_argument);
  EXPECT_THROW(parseAngleRanges("20:10"), std::invalid_argument);
  EXPECT_THROW(parseAngleRanges("10:20x"), std::invalid_argument);
  EXPECT_EQ(parseAngleRanges("").size(), 0U);
}

TEST(TiltedProjection, ABeamWithoutAReturnClearsOnlyInsideTheSlice) {
  ProjectorConfig config;
  config.slice_min_m = -0.5;
  const PoseAt base = [](double) { return poseOf(Vector3d::Zero(), tilt(0.0, 0.2)); };
  LaserScan scan;
  scan.stamp = kScanStamp;
  scan.angle_min = degToRad(-1.0);
  scan.angle_increment = degToRad(1.0);
  scan.range_max = 100.0;
  scan.ranges.assign(93, 80.0F);  // returns beyond the range limit
  scan.ranges[1] = scan.ranges[91] = kNothing;
  const AttitudeBuffer attitude = imuOf(base);
  VehicleState vehicle;
  vehicle.attitude = &attitude;
  const Projection result = ScanProjector(config).project(scan, Isometry3d::Identity(), vehicle);
  ASSERT_EQ(result.scan.rays.size(), 95U);  // each with a ray that is only presumably free
  ASSERT_TRUE(result.scan.rays[91].no_return && result.scan.rays[93].no_return);
  EXPECT_NEAR(result.scan.rays[91].end.x(), 0.5 / std::tan(0.2), 1e-4);
  EXPECT_NEAR(result.scan.rays[93].end.y(), 10.0, 1e-4);
}

}  // namespace
}  // namespace kestrel
