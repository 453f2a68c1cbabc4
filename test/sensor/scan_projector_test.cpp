// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/scan_projector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNoRange = std::numeric_limits<float>::quiet_NaN();

LaserScan makeScan(std::vector<float> ranges) {
  LaserScan scan;
  scan.stamp = 1284000000.25;
  scan.angle_min = 0.0;
  scan.angle_increment = kPi / 2.0;
  scan.range_min = 0.05;
  scan.range_max = 60.0;
  scan.ranges = std::move(ranges);
  return scan;
}

/// A slice so high that only the beam filter has an effect.
ProjectorConfig projectorConfig(const BeamFilterConfig& beams) {
  ProjectorConfig config;
  config.beams = beams;
  config.slice_min_m = -100.0;
  config.slice_max_m = 100.0;
  return config;
}

Projection project(const LaserScan& scan, const BeamFilterConfig& config = BeamFilterConfig(),
                   const Eigen::Isometry3d& base_T_laser = Eigen::Isometry3d::Identity()) {
  return ScanProjector(projectorConfig(config)).project(scan, base_T_laser);
}

/// The same without the rays that are only presumably free.
Projection projectCertain(const LaserScan& scan,
                          const BeamFilterConfig& config = BeamFilterConfig()) {
  Projection result = project(scan, config);
  std::vector<PlanarRay>& rays = result.scan.rays;
  rays.erase(
      std::remove_if(rays.begin(), rays.end(), [](const PlanarRay& ray) { return ray.presumed; }),
      rays.end());
  return result;
}

void expectPoint(const Eigen::Vector2f& actual, float x, float y) {
  EXPECT_NEAR(actual.x(), x, 1e-6F);
  EXPECT_NEAR(actual.y(), y, 1e-6F);
}

TEST(ScanProjector, ABeamAtADoorFrameThatIsTenCentimetersDeepIsMixed) {
  // The range in the middle is between wall and door. Where the edge seems farther away, a corridor
  // seems longer.
  const auto hitsWith = [](float middle) {
    LaserScan scan = makeScan({2.0F, 2.0F, 2.0F, middle, 2.12F, 2.12F, 2.12F});
    scan.angle_increment = degToRad(0.25);
    return project(scan).counts.hits;
  };
  EXPECT_EQ(hitsWith(2.06F), 6U);
  EXPECT_EQ(hitsWith(2.01F), 7U) << "the noise of a range";
}

TEST(ScanProjector, ProjectsBeamsIntoTheBaseFrame) {
  const Projection result = project(makeScan({1.0F, 2.0F, 3.0F, 4.0F}));
  ASSERT_EQ(result.error, ScanError::kNone);
  EXPECT_EQ(result.message, "");
  EXPECT_EQ(result.scan.stamp, 1284000000.25);
  EXPECT_EQ(result.scan.time, 1284000000.25);
  ASSERT_EQ(result.scan.rays.size(), 4U);
  expectPoint(result.scan.rays[0].end, 1.0F, 0.0F);
  expectPoint(result.scan.rays[1].end, 0.0F, 2.0F);
  expectPoint(result.scan.rays[2].end, -3.0F, 0.0F);
  expectPoint(result.scan.rays[3].end, 0.0F, -4.0F);
  for (const PlanarRay& ray : result.scan.rays) {
    EXPECT_TRUE(ray.hit);
    expectPoint(ray.origin, 0.0F, 0.0F);
  }
}

TEST(ScanProjector, AppliesTheMounting) {
  Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();
  base_T_laser.translate(Eigen::Vector3d(0.1, -0.2, 0.3));
  base_T_laser.rotate(Eigen::AngleAxisd(kPi / 2.0, Eigen::Vector3d::UnitZ()));
  const Projection result = project(makeScan({1.0F, 2.0F}), BeamFilterConfig(), base_T_laser);
  ASSERT_EQ(result.scan.rays.size(), 2U);
  expectPoint(result.scan.rays[0].origin, 0.1F, -0.2F);
  expectPoint(result.scan.rays[0].end, 0.1F, 0.8F);
  expectPoint(result.scan.rays[1].end, -1.9F, -0.2F);
}

TEST(ScanProjector, MirrorsAnUpsideDownLaser) {
  Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();
  base_T_laser.rotate(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));
  const Projection result = project(makeScan({1.0F, 2.0F}), BeamFilterConfig(), base_T_laser);
  ASSERT_EQ(result.scan.rays.size(), 2U);
  expectPoint(result.scan.rays[0].end, 1.0F, 0.0F);
  expectPoint(result.scan.rays[1].end, 0.0F, -2.0F);
}

TEST(ScanProjector, ProjectsATiltedBeamToTheHorizontalPlane) {
  Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();
  base_T_laser.rotate(Eigen::AngleAxisd(kPi / 3.0, Eigen::Vector3d::UnitY()));
  const Projection result = project(makeScan({2.0F, 2.0F}), BeamFilterConfig(), base_T_laser);
  ASSERT_EQ(result.scan.rays.size(), 2U);
  expectPoint(result.scan.rays[0].end, 1.0F, 0.0F);  // 2 m · cos 60°
  expectPoint(result.scan.rays[1].end, 0.0F, 2.0F);
}

TEST(ScanProjector, KnowsTheHeightsOfItsReturns) {
  // A laser 0.2 m above the base, pitched by 30 degrees: forward it looks down.
  Eigen::Isometry3d base_T_laser(Eigen::Translation3d(0.5, 0.0, 0.2));
  base_T_laser.rotate(Eigen::AngleAxisd(degToRad(30.0), Eigen::Vector3d::UnitY()));
  VehicleState vehicle;
  const LaserScan scan = makeScan({1.0F, 2.0F, 3.0F, 4.0F});
  ScanProjector projector(projectorConfig(BeamFilterConfig()));
  EXPECT_FALSE(projector.project(scan, base_T_laser, vehicle).scan.height.isKnown());
  vehicle.height_m = 2.0;
  const PlanarScan planar = projector.project(scan, base_T_laser, vehicle).scan;
  ASSERT_TRUE(planar.height.isKnown());
  ASSERT_EQ(planar.rays.size(), 4U);
  const float expected[] = {2.2F - 0.5F, 2.2F, 2.2F + 1.5F, 2.2F};
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(planar.height.at(planar.rays[i].end), expected[i], 1e-5F) << i;
  base_T_laser.rotate(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));  // upside down
  const PlanarScan turned = projector.project(scan, base_T_laser, vehicle).scan;
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(turned.height.at(turned.rays[i].end), expected[i], 1e-5F) << i;
}

TEST(ScanProjector, BeamDirectionsStayAccurateUpToTheLastBeam) {
  LaserScan scan = makeScan(std::vector<float>(20000, 10.0F));
  scan.angle_min = -2.5;
  scan.angle_increment = 2.0 * kPi / 20000.0;
  const Projection result = project(scan);
  ASSERT_EQ(result.scan.rays.size(), 20000U);
  for (std::size_t i = 0; i < result.scan.rays.size(); ++i) {
    const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    EXPECT_NEAR(result.scan.rays[i].end.x(), 10.0 * std::cos(angle), 2e-6);
    EXPECT_NEAR(result.scan.rays[i].end.y(), 10.0 * std::sin(angle), 2e-6);
  }
}

TEST(ScanProjector, AcceptsAClockwiseScan) {
  LaserScan scan = makeScan({1.0F, 2.0F});
  scan.angle_increment = -kPi / 2.0;
  expectPoint(project(scan).scan.rays.at(1).end, 0.0F, -2.0F);
}

TEST(ScanProjector, FollowsRep117) {
  BeamFilterConfig config;
  config.min_range_m = 0.5;
  config.max_range_m = 20.0;
  config.clear_range_m = 8.0;
  LaserScan scan = makeScan(
      {kNoRange, kInf, -kInf, 0.0F, -1.0F, 0.25F, 0.5F, 25.0F, 20.0F, 19.0F, -0.0F, 1e-40F});
  scan.angle_increment = 0.1;
  const Projection result = projectCertain(scan, config);
  EXPECT_EQ(result.counts.invalid, 4U);    // NaN, 0, -1, -0
  EXPECT_EQ(result.counts.too_close, 3U);  // -inf, 0.25, the denormal number
  EXPECT_EQ(result.counts.clears, 3U);     // +inf, 25, 20
  EXPECT_EQ(result.counts.hits, 2U);       // 0.5, 19
  ASSERT_EQ(result.scan.rays.size(), 5U);
  EXPECT_EQ(result.scan.hitCount(), 2U);
  expectPoint(result.scan.rays[0].end, 0.5F * std::cos(0.6F), 0.5F * std::sin(0.6F));
  // A return beyond the range limit, then a beam without a return next to one at 0.5 m.
  EXPECT_FALSE(result.scan.rays[1].hit || result.scan.rays[1].no_return);
  expectPoint(result.scan.rays[1].end, 8.0F * std::cos(0.7F), 8.0F * std::sin(0.7F));
  EXPECT_TRUE(result.scan.rays[4].no_return);
}

TEST(ScanProjector, ClearsAtMostUpToTheRangeOfTheSensor) {
  LaserScan scan = makeScan({5.5F, kInf, 5.6F, 5.5F});
  scan.angle_increment = 0.1;
  scan.range_max = 5.6F;
  const Projection result = projectCertain(scan);  // clear_range_m is 10
  EXPECT_EQ(result.counts.clears, 2U);             // some drivers send range_max for no return
  ASSERT_EQ(result.scan.rays.size(), 4U);
  for (const std::size_t i : {2U, 3U}) {
    EXPECT_TRUE(result.scan.rays[i].no_return && !result.scan.rays[i].hit);
    EXPECT_NEAR(result.scan.rays[i].end.norm(), 5.5F * std::cos(0.15F) / std::cos(0.05F) - 0.05F,
                1e-3F);
  }
}

TEST(ScanProjector, ABeamWithoutAReturnClearsUpToTheLineBetweenItsNeighbors) {
  // A wall at x = 4 m; a window gives no return.
  std::vector<float> ranges;
  for (int i = -40; i <= 40; ++i) {
    const bool window = i > -30 && i < 20;
    ranges.push_back(window ? kInf : static_cast<float>(4.0 / std::cos(degToRad(1.0) * i)));
  }
  LaserScan scan = makeScan(ranges);
  scan.angle_min = degToRad(-40.0);
  scan.angle_increment = degToRad(1.0);
  const Projection result = projectCertain(scan);
  ASSERT_EQ(result.scan.rays.size(), ranges.size());
  for (const PlanarRay& ray : result.scan.rays) {
    const float before = ray.no_return ? 4.0F - 0.05F * ray.end.normalized().x() : 4.0F;
    EXPECT_NEAR(ray.end.x(), before, 1e-3F);
    EXPECT_NE(ray.no_return, ray.hit);
  }
}

TEST(ScanProjector, WithoutNeighborsNothingIsCleared) {
  LaserScan scan = makeScan(std::vector<float>(90, kInf));
  scan.angle_increment = degToRad(4.0);
  for (const PlanarRay& ray : projectCertain(scan).scan.rays) {
    EXPECT_EQ(ray.end, ray.origin);
  }
  scan.ranges[45] = 2.0F;  // all others are more than half a turn between it and itself
  for (const PlanarRay& ray : projectCertain(scan).scan.rays) {
    EXPECT_EQ(ray.end.norm(), ray.hit ? 2.0F : 0.0F);
  }
}

TEST(ScanProjector, BeyondTheLineTheSpaceIsOnlyPresumablyFree) {
  LaserScan scan = makeScan({4.0F, kInf, 4.0F});
  scan.angle_increment = 0.1;
  const std::vector<PlanarRay> rays = project(scan).scan.rays;
  ASSERT_EQ(rays.size(), 4U);
  EXPECT_TRUE(rays[2].no_return && !rays[2].presumed);
  EXPECT_TRUE(rays[3].presumed && !rays[3].no_return && !rays[3].hit);
  EXPECT_NEAR(rays[3].end.norm(), 10.0F, 1e-3F);  // clear_range_m
}

TEST(ScanProjector, ClearRangeZeroTurnsClearingOff) {
  BeamFilterConfig config;
  config.clear_range_m = 0.0;
  const Projection result = project(makeScan({kInf, 2.0F, 95.0F}), config);
  EXPECT_EQ(result.counts.clears, 2U);
  ASSERT_EQ(result.scan.rays.size(), 1U);
  EXPECT_TRUE(result.scan.rays[0].hit);
}

TEST(ScanProjector, TreatsARangeMaxOfZeroAsUnset) {
  LaserScan scan = makeScan({2.0F, 79.0F, 81.0F});
  scan.range_max = 0.0;
  const Projection result = project(scan);
  EXPECT_EQ(result.error, ScanError::kNone);
  EXPECT_EQ(result.counts.hits, 2U);
  EXPECT_EQ(result.counts.clears, 1U);
}

TEST(ScanProjector, AScanWithoutReturnsClears) {
  const Projection result = project(makeScan({kInf, kInf, kInf}));
  EXPECT_EQ(result.error, ScanError::kNone);
  EXPECT_EQ(result.counts.clears, 3U);
  EXPECT_EQ(result.scan.hitCount(), 0U);
}

TEST(ScanProjector, RefusesAScanWithoutAValidBeam) {
  const Projection result = project(makeScan({kNoRange, kNoRange, -kInf, 0.01F}));
  EXPECT_EQ(result.error, ScanError::kNoValidBeam);
  EXPECT_EQ(result.message, "no usable beam: 2 invalid, 2 too close");
  EXPECT_EQ(project(makeScan({})).error, ScanError::kNoBeams);
}

TEST(ScanProjector, RefusesTooManyBeams) {
  BeamFilterConfig config;
  config.max_beams = 3;
  EXPECT_EQ(project(makeScan({1.0F, 1.0F, 1.0F}), config).error, ScanError::kNone);
  const Projection result = project(makeScan({1.0F, 1.0F, 1.0F, 1.0F}), config);
  EXPECT_EQ(result.error, ScanError::kTooManyBeams);
  EXPECT_EQ(result.message, "the scan has 4 beams, max_beams allows 3");
  EXPECT_EQ(project(makeScan(std::vector<float>(10000000, 1.0F))).error, ScanError::kTooManyBeams);
}

TEST(ScanProjector, RefusesBadGeometry) {
  const auto with = [](void (*change)(LaserScan&)) {
    LaserScan scan = makeScan({1.0F, 1.0F, 1.0F, 1.0F});
    change(scan);
    const Projection result = project(scan);
    EXPECT_EQ(result.message.empty(), result.error == ScanError::kNone);
    EXPECT_TRUE(result.scan.rays.empty() || result.error == ScanError::kNone);
    return result.error;
  };
  EXPECT_EQ(with([](LaserScan& s) { s.angle_increment = 0.0; }), ScanError::kBadGeometry);
  EXPECT_EQ(with([](LaserScan& s) { s.angle_increment = kNoRange; }), ScanError::kBadGeometry);
  EXPECT_EQ(with([](LaserScan& s) { s.angle_increment = kInf; }), ScanError::kBadGeometry);
  EXPECT_EQ(with([](LaserScan& s) { s.angle_increment = 4.0; }), ScanError::kBadGeometry);
  EXPECT_EQ(with([](LaserScan& s) { s.angle_min = kNoRange; }), ScanError::kBadGeometry);
  EXPECT_EQ(with([](LaserScan& s) { s.angle_min = -kInf; }), ScanError::kBadGeometry);
  EXPECT_EQ(with([](LaserScan& s) { s.range_max = kNoRange; }), ScanError::kBadGeometry);
  EXPECT_EQ(with([](LaserScan& s) { s.range_min = kNoRange; }), ScanError::kBadGeometry);
  EXPECT_EQ(with([](LaserScan& s) { s.range_max = s.range_min; }), ScanError::kBadGeometry);
  EXPECT_EQ(with([](LaserScan& s) { s.range_max = kInf; }), ScanError::kNone);
  EXPECT_EQ(with([](LaserScan& s) { s.stamp = kNoRange; }), ScanError::kBadStamp);
  EXPECT_EQ(with([](LaserScan& s) { s.stamp = kInf; }), ScanError::kBadStamp);
}

TEST(ScanProjector, AllowsOneBeamMoreThanAFullTurn) {
  LaserScan scan = makeScan(std::vector<float>(361, 1.0F));
  scan.angle_increment = degToRad(1.0);
  EXPECT_EQ(project(scan).error, ScanError::kNone);
  scan.ranges.resize(363, 1.0F);
  EXPECT_EQ(project(scan).error, ScanError::kBadGeometry);
}

TEST(ScanProjector, RefusesAMountingThatIsNotFinite) {
  Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();
  base_T_laser.translation().x() = std::nan("");
  EXPECT_EQ(project(makeScan({1.0F}), BeamFilterConfig(), base_T_laser).error,
            ScanError::kBadGeometry);
}

TEST(ScanProjector, EveryErrorHasAText) {
  EXPECT_STREQ(toString(ScanError::kNone), "none");
  EXPECT_STREQ(toString(ScanError::kNoBeams), "no-beams");
  EXPECT_STREQ(toString(ScanError::kBadGeometry), "bad-geometry");
  EXPECT_STREQ(toString(ScanError::kTooManyBeams), "too-many-beams");
  EXPECT_STREQ(toString(ScanError::kNoValidBeam), "no-valid-beam");
  EXPECT_STREQ(toString(ScanError::kBadStamp), "bad-stamp");
}

}  // namespace
}  // namespace kestrel
