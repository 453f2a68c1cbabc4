// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/sensor/scan_projector.h"
#include "room_log.h"

namespace kestrel {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

LaserScan roomScan() {
  LaserScan scan = RoomFlight::scan(0);
  scan.range_max = 12.0;
  return scan;
}

LaserScan scaled(LaserScan scan, double factor) {
  for (float& range : scan.ranges) range *= static_cast<float>(factor);
  return scan;
}

Projection projectScan(const LaserScan& scan) {
  return ScanProjector(ProjectorConfig()).project(scan, Eigen::Isometry3d::Identity());
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(ScanUnits, AGoodScanHasNoWarning) {
  LaserScan scan = roomScan();
  scan.time_increment = 0.1 / 360.0;
  const Projection result = projectScan(scan);
  EXPECT_EQ(result.error, ScanError::kNone) << result.message;
  EXPECT_EQ(textOf(result.warnings), "");
}

TEST(ScanUnits, TimeIncrementInAnotherUnitIsNamedAndIgnored) {
  for (const auto& [factor, unit] : {std::pair{1e9, "nanoseconds?"},
                                     {1e6, "microseconds?"},
                                     {1e3, "milliseconds?"},
                                     {-1e9, "nanoseconds?"},
                                     {1e30, "It is ignored"},
                                     {kMissing, "It is ignored"}}) {
    LaserScan scan = roomScan();
    scan.time_increment = factor * 0.1 / 360.0;
    const Projection result = projectScan(scan);
    EXPECT_EQ(result.error, ScanError::kNone) << result.message;
    ASSERT_EQ(result.warnings.size(), 1U) << factor;
    EXPECT_STREQ(result.warnings[0].kind, "time-increment");
    EXPECT_TRUE(contains(result.warnings[0].text, unit)) << result.warnings[0].text;
    EXPECT_LT(result.warnings[0].text.size(), 200U);
    EXPECT_EQ(sweepTimes(scan).first, scan.stamp);
    EXPECT_EQ(sweepTimes(scan).last, scan.stamp);
  }
}

TEST(ScanUnits, FewBeamsAreSaid) {
  LaserScan scan = roomScan();
  scan.ranges.resize(kMinBeamsToMatch);
  EXPECT_TRUE(projectScan(scan).warnings.empty());
  scan.ranges.resize(4);
  const Projection result = projectScan(scan);
  EXPECT_EQ(result.error, ScanError::kNone);
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_TRUE(contains(result.warnings[0].text, "the scan has 4 beams"));
}

TEST(ScanUnits, RangesInMillimetersAreRefused) {
  for (const double range_max : {12.0, 12000.0, 0.0}) {
    LaserScan scan = scaled(roomScan(), 1000.0);
    scan.range_max = range_max;
    scan.ranges[3] = 0.0F;  // no return
    scan.ranges[4] = std::numeric_limits<float>::infinity();
    scan.ranges[5] = 6.0F;  // an error code of the laser
    const Projection result = projectScan(scan);
    EXPECT_EQ(result.error, ScanError::kWrongUnit) << range_max;
    EXPECT_TRUE(contains(result.message, "millimeters?")) << result.message;
    EXPECT_LT(result.message.size(), 200U);
  }
  const std::string message = projectScan(scaled(roomScan(), 1000.0)).message;
  EXPECT_TRUE(contains(message, "every beam is beyond range_max 12 m")) << message;
}

TEST(ScanUnits, LimitsInMillimetersAreRefused) {
  LaserScan scan = roomScan();
  scan.range_min = 100.0;
  scan.range_max = 12000.0;
  const Projection result = projectScan(scan);
  EXPECT_EQ(result.error, ScanError::kWrongUnit);
  EXPECT_TRUE(contains(result.message, "every beam is closer than range_min 100 m"))
      << result.message;
  scan.range_min = 0.05;  // range_max alone does no harm
  EXPECT_EQ(projectScan(scan).error, ScanError::kNone);
}

/// In the open: every driver has its own number for "no return".
TEST(ScanUnits, CodesForNoReturnAreNoRanges) {
  for (const float code : {12.001F, 13.0F, 65.533F, 1000.0F, 9999.0F, 65535.0F}) {
    LaserScan scan = roomScan();
    scan.ranges.assign(scan.ranges.size(), code);
    EXPECT_EQ(projectScan(scan).error, ScanError::kNone) << code;
    scan.ranges[7] = 3.0F;
    EXPECT_EQ(projectScan(scan).error, ScanError::kNone) << code;
  }
}

/// A SICK LMS in a CARMEN log, which gives no minimum range.
TEST(ScanUnits, TwoCodesForNoReturnAreNoRanges) {
  LaserScan scan = roomScan();
  scan.range_min = 0.0;
  scan.range_max = 80.0;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i)
    scan.ranges[i] = i % 3 == 0 ? 81.83F : 81.91F;
  EXPECT_EQ(projectScan(scan).error, ScanError::kNone);
}

TEST(ScanUnits, ALongRangeLaserInTheOpenIsAccepted) {
  LaserScan scan = scaled(roomScan(), 60.0);  // 90 to 300 m
  scan.range_max = 350.0;
  EXPECT_EQ(projectScan(scan).error, ScanError::kNone);
  EXPECT_EQ(projectScan(scan).counts.hits, 0U);  // max_range
}

TEST(ScanUnits, CloudPointsWithoutATimeAreInvalid) {
  PointCloud cloud;
  cloud.stamp = 5.0;
  for (int i = 0; i < 100; ++i) {
    const auto angle = static_cast<float>(degToRad(3.6 * i));
    const float time =
        i % 2 == 0 ? std::numeric_limits<float>::quiet_NaN() : 0.001F * static_cast<float>(i);
    cloud.points.push_back({3.0F * std::cos(angle), 3.0F * std::sin(angle), 0.0F, time});
  }
  const Projection result =
      ScanProjector(ProjectorConfig()).project(cloud, Eigen::Isometry3d::Identity());
  EXPECT_EQ(result.error, ScanError::kNone) << result.message;
  EXPECT_EQ(result.counts.invalid, 50U);
  EXPECT_EQ(result.counts.hits, 50U);
}

}  // namespace
}  // namespace kestrel
