// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/odometry_selection.h"

#include <gtest/gtest.h>

#include "graph_samples.h"

namespace kestrel {
namespace {

/// A straight drive with a scan per meter, exact matches and odometry.
struct Straight {
  static constexpr std::size_t kCount = 60;
  std::vector<OdometryPoint> points;
  std::vector<bool> doubtful = std::vector<bool>(kCount, false);
  std::size_t without_odometry = kCount;  ///< this keyframe
  PoseGraph graph;

  Straight() {
    for (std::size_t i = 0; i < kCount; ++i) {
      const Pose2 pose(static_cast<double>(i), 0.0, 0.0);
      points.push_back({i, pose, pose});
      graph.vertices.push_back({pose, false});
      doubtful[i] = i % 4 == 3;
    }
  }

  /// The match of one keyframe, or of all from it on, is this much farther.
  void moveMatch(std::size_t first, std::size_t end, double distance_m) {
    for (std::size_t i = first; i < end; ++i) points[i].matched.x += distance_m;
  }
  void moveOdometry(std::size_t first, std::size_t end, double distance_m) {
    for (std::size_t i = first; i < end; ++i) points[i].measured.x += distance_m;
  }

  OdometrySelection select(bool is_late = true) {
    graph.edges.clear();
    for (std::size_t i = 1; i < kCount; ++i)
      graph.edges.push_back({i - 1, i, points[i - 1].matched.between(points[i].matched),
                             sampleInformation(), EdgeKind::kOdometry});
    OdometryWorth worth;
    worth.position_m2 = worth.position_growth = 1e-4;
    worth.yaw_rad2 = worth.yaw_growth = 1e-5;
    std::vector<OdometryPoint> measured;
    for (const OdometryPoint& point : points)
      if (point.keyframe != without_odometry) measured.push_back(point);
    return selectOdometry(measured, worth, OdometryChain(graph), doubtful, is_late);
  }
};

bool uses(const OdometrySelection& selection, std::size_t keyframe) {
  for (const OdometryPoint& point : selection.points)
    if (point.keyframe == keyframe) return true;
  return false;
}

TEST(OdometrySelection, WhatAgreesIsUsed) {
  Straight drive;
  const OdometrySelection selection = drive.select();
  EXPECT_EQ(selection.points.size(), Straight::kCount);
  EXPECT_EQ(selection.refuted, std::vector<bool>(Straight::kCount, false));
}

TEST(OdometrySelection, ADoubtfulMatchThatSlipsIsRefuted) {
  Straight drive;
  drive.moveMatch(31, Straight::kCount, 3.0);
  const OdometrySelection selection = drive.select();
  EXPECT_TRUE(selection.refuted[31]);
  EXPECT_TRUE(uses(selection, 31));
}

TEST(OdometrySelection, ASingleDoubtfulMatchIsRefutedAndItsOdometryIsUsed) {
  Straight drive;
  drive.moveMatch(31, 32, 1.5);
  const OdometrySelection selection = drive.select();
  EXPECT_TRUE(selection.refuted[31]);
  EXPECT_FALSE(selection.refuted[32]);
  EXPECT_TRUE(uses(selection, 31));
}

TEST(OdometrySelection, AnOdometryInTimeIsLeftOutThere) {
  Straight drive;
  drive.moveMatch(31, 32, 1.5);
  const OdometrySelection selection = drive.select(false);
  EXPECT_FALSE(selection.refuted[31]);
  EXPECT_FALSE(uses(selection, 31));
}

/// The match before slips or the one after it: a late odometry blames the doubtful one of both. One
/// in time blames neither, but what lies between them, because wheels may have slipped as well.
TEST(OdometrySelection, AnOdometryInTimeLeavesALastingContradictionOpen) {
  Straight drive;
  drive.moveMatch(32, Straight::kCount, 3.0);
  EXPECT_TRUE(drive.select().refuted[31]) << "it is doubtful";
  const OdometrySelection selection = drive.select(false);
  EXPECT_EQ(selection.refuted, std::vector<bool>(Straight::kCount, false));
  EXPECT_TRUE(uses(selection, 32));
}

TEST(OdometrySelection, AtAContradictionOfAnOdometryInTimeDoubtfulMatchesLoseTheirWeight) {
  Straight drive;
  drive.moveMatch(31, Straight::kCount, 3.0);
  drive.without_odometry = 31;
  std::vector<bool> between(Straight::kCount, false);
  EXPECT_EQ(drive.select().refuted, between) << "those that are compared are not doubtful";
  between[31] = true;
  EXPECT_EQ(drive.select(false).refuted, between);
}

TEST(OdometrySelection, AGoodMatchIsNotRefuted) {
  Straight drive;
  drive.moveOdometry(30, 31, 1.5);
  const OdometrySelection selection = drive.select();
  EXPECT_FALSE(selection.refuted[30]);
  EXPECT_FALSE(uses(selection, 30)) << "its odometry was measured at another time";
}

/// The odometry contradicts good and doubtful matches alike, so it is the odometry that errs.
TEST(OdometrySelection, AnOdometryThatIsOftenWrongRefutesNothing) {
  Straight drive;
  for (std::size_t i = 6; i + 6 < Straight::kCount; i += 5) drive.moveOdometry(i, i + 1, 1.5);
  const OdometrySelection selection = drive.select();
  EXPECT_EQ(selection.refuted, std::vector<bool>(Straight::kCount, false));
}

TEST(OdometrySelection, WheelsThatOftenSlipRefuteNothing) {
  Straight drive;
  for (std::size_t i = 7; i < Straight::kCount; i += 7)
    drive.moveOdometry(i, Straight::kCount, 0.5);
  for (std::size_t i = 0; i < Straight::kCount; ++i) drive.doubtful[i] = i >= Straight::kCount / 2;
  const OdometrySelection selection = drive.select();
  EXPECT_EQ(selection.refuted, std::vector<bool>(Straight::kCount, false));
}

/// Larger than all errors that good matches show: the match errs, although smaller errors of the
/// odometry are frequent.
TEST(OdometrySelection, TheSizeOfAContradictionCounts) {
  Straight drive;
  for (std::size_t i = 6; i + 6 < Straight::kCount; i += 5) drive.moveOdometry(i, i + 1, 1.0);
  drive.moveMatch(35, 36, 5.0);
  const OdometrySelection selection = drive.select();
  EXPECT_TRUE(selection.refuted[35]);
  EXPECT_FALSE(selection.refuted[11]);
}

}  // namespace
}  // namespace kestrel
