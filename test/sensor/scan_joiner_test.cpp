// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/scan_joiner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr std::size_t kBeams = 360;
constexpr double kBeamStep = 2.0 * kPi / kBeams;  // rad
constexpr double kBeamTime = 0.1 / kBeams;        // s

/// Beams `first` to `first + count` of a laser that turns ten times per second. The range of a beam
/// is the number of the beam in its turn, plus 1.
LaserScan beams(std::size_t first, std::size_t count, double direction = 1.0) {
  LaserScan scan;
  scan.stamp = 1000.0 + static_cast<double>(first) * kBeamTime;
  scan.angle_min =
      std::remainder(direction * (static_cast<double>(first) * kBeamStep - kPi), 2.0 * kPi);
  scan.angle_increment = direction * kBeamStep;
  scan.time_increment = kBeamTime;
  scan.range_min = 0.1;
  scan.range_max = 500.0;
  for (std::size_t i = first; i < first + count; ++i) {
    scan.ranges.push_back(static_cast<float>(i % kBeams + 1));
  }
  return scan;
}

void append(std::vector<LaserScan>& all, std::vector<LaserScan> more) {
  for (LaserScan& scan : more) all.push_back(std::move(scan));
}

/// Joins turns of segments of `count` beams; leaves out the segments for which `lost` is true.
template <typename Lost>
std::vector<LaserScan> joinSegments(std::size_t turns, std::size_t count, double direction,
                                    Lost lost) {
  ScanJoiner joiner;
  std::vector<LaserScan> scans;
  for (std::size_t i = 0; i * count < turns * kBeams; ++i) {
    if (!lost(i)) append(scans, joiner.add(beams(i * count, count, direction)));
  }
  append(scans, joiner.finish());
  EXPECT_TRUE(joiner.joins());
  return scans;
}

const auto kNone = [](std::size_t) { return false; };

TEST(ScanJoiner, JoinsTheSegmentsOfEachTurn) {
  for (const std::size_t count : {1U, 10U, 30U, 90U, 120U, 180U}) {
    for (const double direction : {1.0, -1.0}) {
      const std::vector<LaserScan> scans = joinSegments(5, count, direction, kNone);
      ASSERT_EQ(scans.size(), 5U) << count << " beams per segment, direction " << direction;
      for (std::size_t turn = 0; turn < scans.size(); ++turn) {
        const LaserScan expected = beams(turn * kBeams, kBeams, direction);
        EXPECT_EQ(scans[turn].ranges, expected.ranges);
        EXPECT_EQ(scans[turn].stamp, expected.stamp);
        EXPECT_NEAR(std::remainder(scans[turn].angle_min - expected.angle_min, 2.0 * kPi), 0, 1e-9);
        EXPECT_EQ(scans[turn].angle_increment, expected.angle_increment);
        EXPECT_EQ(scans[turn].time_increment, expected.time_increment);
      }
    }
  }
}

TEST(ScanJoiner, LostSegmentsLeaveAGapAndTheTurnsStayApart) {
  const std::vector<LaserScan> scans =
      joinSegments(4, 30, 1.0, [](std::size_t i) { return i == 15 || i == 24 || i == 35; });
  ASSERT_EQ(scans.size(), 4U);
  EXPECT_TRUE(std::isnan(scans[1].ranges[90]));
  EXPECT_EQ(scans[1].ranges[120], 121.0F);
  EXPECT_EQ(scans[1].ranges[89], 90.0F);
  EXPECT_EQ(scans[2].ranges[0], 31.0F) << "a turn begins with the first segment that was received";
}

TEST(ScanJoiner, APauseOfManyTurnsBeginsANewTurn) {
  // 3 1/4 turns are missing, so that the angles alone would look as if one segment was lost.
  const std::vector<LaserScan> scans =
      joinSegments(10, 30, 1.0, [](std::size_t i) { return i >= 15 && i < 15 + 39; });
  for (const LaserScan& scan : scans) {
    EXPECT_LE(scan.ranges.size(), kBeams);
    for (std::size_t i = 0; i + 1 < scan.ranges.size(); ++i) {
      if (std::isnan(scan.ranges[i]) || std::isnan(scan.ranges[i + 1])) continue;
      EXPECT_EQ(std::fmod(scan.ranges[i], kBeams) + 1.0F, scan.ranges[i + 1]);
    }
  }
  EXPECT_GE(scans.size(), 6U);
}

TEST(ScanJoiner, DerivesTheTimeBetweenTwoBeamsFromTheStamps) {
  ScanJoiner joiner;
  std::vector<LaserScan> scans;
  for (std::size_t i = 0; i < 24; ++i) {
    LaserScan segment = beams(30 * i, 30);
    segment.time_increment = 0.0;
    append(scans, joiner.add(std::move(segment)));
  }
  ASSERT_EQ(scans.size(), 2U);
  EXPECT_NEAR(scans[1].time_increment, kBeamTime, 1e-9);
}

TEST(ScanJoiner, ScansThatBeginAtTheSameAnglePassThrough) {
  for (const std::size_t count : {1U, 2U, 90U, 270U, 359U, 360U, 361U}) {
    ScanJoiner joiner;
    std::vector<LaserScan> scans;
    for (std::size_t i = 0; i < 5; ++i) {
      LaserScan scan = beams(0, count);
      scan.stamp += 0.1 * static_cast<double>(i);
      append(scans, joiner.add(std::move(scan)));
    }
    append(scans, joiner.finish());
    EXPECT_EQ(scans.size(), 5U) << count;
    EXPECT_FALSE(joiner.joins());
    EXPECT_EQ(scans.back().ranges.size(), count);
  }
}

TEST(ScanJoiner, FullTurnsWithChangingStartAndBeamsPassThrough) {
  ScanJoiner joiner;
  std::size_t received = 0;
  for (std::size_t i = 0; i < 50; ++i) {
    LaserScan scan = beams(0, 330 + (7 * i) % 30);
    scan.angle_increment = 2.0 * kPi / static_cast<double>(scan.ranges.size());
    scan.angle_min += 0.01 * static_cast<double>(i % 5);
    scan.stamp += 0.1 * static_cast<double>(i);
    received += joiner.add(std::move(scan)).size();
  }
  EXPECT_EQ(received, 50U);
  EXPECT_FALSE(joiner.joins());
}

TEST(ScanJoiner, GarbageBetweenSegmentsIsPassedOn) {
  ScanJoiner joiner;
  const double bad[] = {0.0, 1e-300, 1e300, std::numeric_limits<double>::quiet_NaN()};
  std::vector<LaserScan> scans;
  for (std::size_t i = 0; i < 48; ++i) {
    append(scans, joiner.add(beams(30 * i, 30)));
    LaserScan garbage = beams(30 * i, i % 3);
    (i % 2 == 0 ? garbage.angle_increment : garbage.angle_min) = bad[i % 4];
    append(scans, joiner.add(std::move(garbage)));
  }
  append(scans, joiner.finish());
  EXPECT_GE(scans.size(), 48U);
}

}  // namespace
}  // namespace kestrel
