// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/vehicle_returns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {
namespace {

constexpr std::size_t kBeams = 720, kFirstPart = 100, kPartBeams = 30;
constexpr float kPartM = 0.25F;

/// A laser in a room of 8 m x 6 m, and a rod of the landing gear in its view.
class LaserWithPart {
 public:
  LaserScan scanAt(double x, double y, double yaw, bool has_part = true) {
    LaserScan scan;
    scan.angle_min = -kPi;
    scan.angle_increment = 2.0 * kPi / kBeams;
    scan.range_min = 0.05;
    scan.range_max = 30.0;
    for (std::size_t i = 0; i < kBeams; ++i) {
      const double angle = yaw + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
      scan.ranges.push_back(static_cast<float>(wallAt(x, y, angle) + noise_(random_)));
    }
    for (std::size_t i = kFirstPart; has_part && i < kFirstPart + kPartBeams; ++i)
      scan.ranges[i] = kPartM + static_cast<float>(noise_(random_));
    return scan;
  }

 private:
  static double wallAt(double x, double y, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    const double along_x = c > 0.0 ? (4.0 - x) / c : (-4.0 - x) / c;
    const double along_y = s > 0.0 ? (3.0 - y) / s : (-3.0 - y) / s;
    return std::min(along_x, along_y);
  }

  std::mt19937 random_{1};
  std::normal_distribution<double> noise_{0.0, 0.005};
};

/// So many beams of a scan are marked.
std::size_t marked(const VehicleReturns& returns, const LaserScan& scan) {
  std::vector<bool> mask;
  returns.addTo(scan, mask);
  return static_cast<std::size_t>(std::count(mask.begin(), mask.end(), true));
}

class VehicleReturnsTest : public testing::Test {
 protected:
  /// Turns and moves through the room.
  void fly(int scans, bool has_part = true) {
    for (int i = 0; i < scans; ++i) {
      const double t = 0.1 * i;
      returns_.observe(laser_.scanAt(2.0 * std::sin(t), std::cos(0.7 * t), 0.9 * t, has_part));
    }
  }

  LaserWithPart laser_;
  VehicleReturns returns_;
};

TEST_F(VehicleReturnsTest, WhatKeepsItsRangeWhileTheViewChangesIsThePart) {
  fly(200);
  std::vector<bool> mask;
  returns_.addTo(laser_.scanAt(0.0, 0.0, 0.0), mask);
  ASSERT_EQ(mask.size(), kBeams);
  for (std::size_t i = 0; i < kBeams; ++i)
    EXPECT_EQ(mask[i], i >= kFirstPart && i < kFirstPart + kPartBeams) << i;
}

TEST_F(VehicleReturnsTest, AVehicleThatStandsLearnsNothing) {
  for (int i = 0; i < 1000; ++i) returns_.observe(laser_.scanAt(3.6, 0.0, 0.0));
  EXPECT_EQ(marked(returns_, laser_.scanAt(3.6, 0.0, 0.0)), 0U);
}

TEST_F(VehicleReturnsTest, AWallNearbyStays) {
  // Along a wall at 0.5 m, as exactly as a good controller flies.
  for (int i = 0; i < 300; ++i) {
    const double t = 0.1 * i;
    returns_.observe(laser_.scanAt(3.0 * std::sin(0.3 * t), 2.5 + 0.05 * std::sin(t),
                                   0.2 * std::sin(0.5 * t), false));
  }
  EXPECT_EQ(marked(returns_, laser_.scanAt(0.0, 2.5, 0.0, false)), 0U);
}

TEST_F(VehicleReturnsTest, ABeamPastThePartIsUsed) {
  fly(200);
  EXPECT_EQ(marked(returns_, laser_.scanAt(0.0, 0.0, 0.0, false)), 0U);
  const LaserScan scan = laser_.scanAt(0.0, 0.0, 0.0);
  EXPECT_EQ(marked(returns_, scan), kPartBeams) << "the part is remembered";
}

TEST_F(VehicleReturnsTest, AnotherRangeInTheSameDirectionIsNoPartOfTheVehicle) {
  fly(200);
  LaserScan scan = laser_.scanAt(0.0, 0.0, 0.0);
  for (std::size_t i = kFirstPart; i < kFirstPart + kPartBeams; ++i) scan.ranges[i] = 0.5F;
  EXPECT_EQ(marked(returns_, scan), 0U);
}

TEST_F(VehicleReturnsTest, RangesThatAreNoNumbersAndOddAnglesAreHarmless) {
  fly(200);
  LaserScan scan = laser_.scanAt(0.0, 0.0, 0.0);
  scan.angle_min = 1e6;
  scan.angle_increment = -3.0;
  scan.ranges[0] = std::numeric_limits<float>::quiet_NaN();
  scan.ranges[1] = -std::numeric_limits<float>::infinity();
  scan.ranges[2] = std::numeric_limits<float>::infinity();
  returns_.observe(scan);
  marked(returns_, scan);
  scan.ranges.clear();
  returns_.observe(scan);
  EXPECT_EQ(marked(returns_, scan), 0U);
}

TEST(ScanProjector, IgnoresThePartsOfTheVehicleOfEachLaser) {
  for (const bool is_on : {true, false}) {
    ProjectorConfig config;
    config.find_vehicle = is_on;
    ScanProjector projector(config);
    LaserWithPart front, rear;
    for (int i = 0; i < 200; ++i) {
      const double t = 0.1 * i, x = 2.0 * std::sin(t), y = std::cos(0.7 * t), yaw = 0.9 * t;
      LaserScan scan = front.scanAt(x, y, yaw);
      scan.frame = "front";
      scan.stamp = t;
      const Projection projection = projector.project(scan, Eigen::Isometry3d::Identity());
      LaserScan other = rear.scanAt(x, y, yaw + kPi, false);
      other.frame = "rear";
      other.stamp = t + 0.05;
      EXPECT_EQ(projector.project(other, Eigen::Isometry3d::Identity()).counts.masked, 0U);
      if (i < 199) continue;
      EXPECT_EQ(projection.counts.masked, is_on ? kPartBeams : 0U);
    }
    projector.configure(config);
    LaserScan scan = front.scanAt(0.0, 0.0, 0.0);
    scan.frame = "front";
    scan.stamp = 20.0;
    EXPECT_EQ(projector.project(scan, Eigen::Isometry3d::Identity()).counts.masked,
              is_on ? kPartBeams : 0U)
        << "another configuration keeps what is known";
  }
}

}  // namespace
}  // namespace kestrel
