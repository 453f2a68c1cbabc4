// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/range_correction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {
namespace {

TEST(RangeCorrection, IsLinearBetweenRangesAndConstantBeyond) {
  const RangeCorrection correction("4:0.2, 6:-0.4");
  EXPECT_FLOAT_EQ(correction.corrected(2.0F), 2.1F);  // linear from 0 at range 0
  EXPECT_FLOAT_EQ(correction.corrected(4.0F), 4.2F);
  EXPECT_FLOAT_EQ(correction.corrected(5.0F), 4.9F);
  EXPECT_FLOAT_EQ(correction.corrected(9.0F), 8.6F);
}

TEST(RangeCorrection, DoesNotChangeInvalidRanges) {
  const RangeCorrection correction("4:0.2");
  EXPECT_EQ(correction.corrected(0.0F), 0.0F);
  EXPECT_EQ(correction.corrected(-1.0F), -1.0F);
  EXPECT_EQ(correction.corrected(std::numeric_limits<float>::infinity()),
            std::numeric_limits<float>::infinity());
  EXPECT_TRUE(std::isnan(correction.corrected(std::nanf(""))));
}

TEST(RangeCorrection, AnEmptyTextCorrectsNothing) {
  EXPECT_TRUE(RangeCorrection("").isEmpty());
  EXPECT_EQ(RangeCorrection("").corrected(3.0F), 3.0F);
}

TEST(RangeCorrection, RefusesInvalidTexts) {
  for (const char* text : {"4", "4:", "4:x", "0:1", "-1:0.1", "4:0.1, 3:0.1", "4:-5", "4:nan"}) {
    EXPECT_THROW(RangeCorrection{text}, std::invalid_argument) << text;
  }
}

TEST(RangeCorrection, IsAppliedByTheScanProjector) {
  ProjectorConfig config;
  config.range_correction = "2:0.1";
  LaserScan scan;
  scan.stamp = 1.0;
  scan.angle_increment = 0.1;
  scan.range_max = 30.0;
  scan.ranges = {2.0F};
  const Projection result = ScanProjector(config).project(scan, Eigen::Isometry3d::Identity());
  ASSERT_EQ(result.scan.rays.size(), 1U);
  EXPECT_FLOAT_EQ(result.scan.rays[0].end.x(), 2.1F);
}

}  // namespace
}  // namespace kestrel
