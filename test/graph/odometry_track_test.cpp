// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/odometry_track.h"

#include <gtest/gtest.h>

#include "graph_samples.h"
#include "kestrel_slam/graph/optimizer.h"

namespace kestrel {
namespace {

/// Three laps round a square with noisy matches, and an odometry by `measure(scan)`.
struct MeasuredDrive {
  std::vector<Pose2> truth = squareDrive(3);
  Random random{7};
  PoseGraph matches = odometryGraph(truth, random);
  OdometryTrack track;
  std::vector<bool> doubtful = std::vector<bool>(truth.size(), false);

  template <typename Measure>
  explicit MeasuredDrive(Measure measure) {
    for (std::size_t i = 0; i < truth.size(); ++i) {
      track.add(measure(truth, i));
      track.addKeyframe(i, matches.vertices[i].pose);
    }
  }

  /// Mean error of the optimized graph, m.
  double error() {
    const OdometryChain chain(matches);
    track.learn(chain);
    PoseGraph joint = matches;
    track.addTo(joint, chain, doubtful);
    EXPECT_EQ(problemOf(joint), "");
    EXPECT_TRUE(optimize(joint).ok());
    joint.vertices.resize(truth.size());
    return meanDistance(joint, truth);
  }
  double matchError() const { return meanDistance(matches, truth); }
};

TEST(OdometryTrack, AnOdometryWithErrorsThatDoNotGrowHoldsTheGraph) {
  Random random(3);
  MeasuredDrive drive([&](const std::vector<Pose2>& truth, std::size_t i) {
    return truth[i] *
           Pose2(0.05 * random.gaussian(), 0.05 * random.gaussian(), 0.05 * random.gaussian());
  });
  EXPECT_LT(drive.error(), 0.6 * drive.matchError());
  EXPECT_NEAR(std::sqrt(drive.track.worth().yaw_rad2), 0.05, 0.02);
}

TEST(OdometryTrack, AnOdometryThatIsAScanLateIsAsGood) {
  MeasuredDrive drive(
      [](const std::vector<Pose2>& truth, std::size_t i) { return truth[i == 0 ? 0 : i - 1]; });
  EXPECT_LT(drive.error(), 0.6 * drive.matchError());
  EXPECT_EQ(drive.track.delayScans(), 1);
}

TEST(OdometryTrack, SystematicErrorsDoNoHarm) {
  Pose2 odometry;
  MeasuredDrive drive([&](const std::vector<Pose2>& truth, std::size_t i) {
    if (i == 0) return odometry;
    const Pose2 step = truth[i - 1].between(truth[i]);
    odometry = odometry * Pose2(0.9 * step.x, 0.9 * step.y, step.yaw + 0.02 * step.distance());
    return odometry;
  });
  EXPECT_LT(drive.error(), 1.2 * drive.matchError());
  EXPECT_NEAR(drive.track.worth().scale, 1.0 / 0.9, 0.02);
}

TEST(OdometryTrack, SlipsDoNoHarm) {
  Pose2 odometry;
  MeasuredDrive drive([&](const std::vector<Pose2>& truth, std::size_t i) {
    if (i == 0) return odometry;
    const Pose2 slip = i % 30 == 0 ? Pose2(0.5, 0.3, 0.0) : Pose2();
    odometry = odometry * truth[i - 1].between(truth[i]) * slip;
    return odometry;
  });
  EXPECT_LT(drive.error(), 1.1 * drive.matchError());
}

/// Every fifth step the odometry counts in the wrong direction.
TEST(OdometryTrack, MotionsAgainstTheOdometryAreReversed) {
  const auto errorWith = [](bool is_told) {
    MeasuredDrive drive([](const std::vector<Pose2>& truth, std::size_t i) { return truth[i]; });
    drive.track = OdometryTrack();
    Pose2 odometry;
    for (std::size_t i = 0; i < drive.truth.size(); ++i) {
      const bool is_against = i > 0 && i % 5 == 0;
      if (i > 0) {
        const Pose2 step = drive.truth[i - 1].between(drive.truth[i]);
        odometry = odometry * (is_against ? reversed(step) : step);
      }
      drive.track.add(odometry, is_told && is_against);
      drive.track.addKeyframe(i, drive.matches.vertices[i].pose);
    }
    return std::pair(drive.error(), drive.matchError());
  };
  const auto [error, match_error] = errorWith(true);
  EXPECT_LT(error, 0.6 * match_error);
  EXPECT_LT(error, errorWith(false).first);
}

/// Matches of a part of the drive stand still while the vehicle moves on.
TEST(OdometryTrack, DoubtfulMatchesThatSlipDoNoHarm) {
  const auto exact = [](const std::vector<Pose2>& truth, std::size_t i) { return truth[i]; };
  MeasuredDrive drive(exact);
  const double error = MeasuredDrive(exact).error();
  drive.track = OdometryTrack();
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    if (i > 0) {
      PoseEdge& edge = drive.matches.edges[i - 1];
      if (i >= 40 && i < 46) edge.measured.x = 0.1, drive.doubtful[i] = true;
      drive.matches.vertices[i].pose = drive.matches.vertices[i - 1].pose * edge.measured;
    }
    drive.track.add(drive.truth[i]);
    drive.track.addKeyframe(i, drive.matches.vertices[i].pose);
  }
  EXPECT_LT(drive.error(), 1.2 * error);
}

TEST(OdometryTrack, WithoutOdometryTheGraphStaysAsItIs) {
  MeasuredDrive drive(
      [](const std::vector<Pose2>&, std::size_t) { return std::optional<Pose2>(); });
  EXPECT_TRUE(drive.track.empty());
  EXPECT_NEAR(drive.error(), drive.matchError(), 1e-9);
}

}  // namespace
}  // namespace kestrel
