// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/pose_uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kestrel_slam/geometry/pose_covariance.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

UncertainPose poseAt(double x, double map_variance, double match_variance) {
  UncertainPose result;
  result.pose = Pose2(x, 0.0, 0.0);
  result.map_covariance(1, 1) = map_variance;
  result.match_covariance(1, 1) = match_variance;
  return result;
}

/// Two matches at the same time, as when a vehicle was found: no time, no error, and no NaN.
TEST(AlongError, WithoutAnErrorNoSpeedIsCorrected) {
  AlongError error;
  error.predict(0.0, 0.0, PredictionSource::kVelocity);
  EXPECT_EQ(error.speedGain(), 0.0);
}

TEST(RelativeCovariance, TheCommonErrorCancels) {
  const Eigen::Matrix3d here = relativeCovariance(poseAt(0, 0.5, 1e-4), poseAt(2, 0.5, 2e-4));
  EXPECT_NEAR(here(1, 1), 3e-4, 1e-12);
  // For two places in one chain of scans the difference remains, in both orders.
  EXPECT_NEAR(relativeCovariance(poseAt(0, 0.1, 0), poseAt(2, 0.5, 0))(1, 1), 0.4, 1e-12);
  EXPECT_NEAR(relativeCovariance(poseAt(0, 0.5, 0), poseAt(2, 0.1, 0))(1, 1), 0.4, 1e-12);
}

TEST(RelativeCovariance, IsInTheFrameOfTheFirstPose) {
  UncertainPose a = poseAt(0, 0, 1e-4), b = poseAt(0, 0, 0);
  a.pose = b.pose = Pose2(1, 2, degToRad(90.0));
  const Eigen::Matrix3d result = relativeCovariance(a, b);
  EXPECT_NEAR(result(0, 0), 1e-4, 1e-12);
  EXPECT_NEAR(result(1, 1), 0.0, 1e-12);
}

TEST(RelativeCovariance, AYawErrorOfTheFirstPoseIsAPositionErrorOfTheSecond) {
  UncertainPose a = poseAt(0, 0, 0), b = poseAt(10, 0, 0);
  a.match_covariance(2, 2) = 1e-4;
  EXPECT_NEAR(relativeCovariance(a, b)(1, 1), 1e-2, 1e-12);
}

TEST(MapUncertainty, IsThatOfTheScansThatFirstSawTheWalls) {
  Submap map{OccupancyGridConfig()};
  MapUncertainty uncertainty;
  const Points points = hitsOf(room::scanFrom(Pose2()));
  EXPECT_EQ(uncertainty.at(map.surface(), points, Pose2()), Eigen::Matrix3d::Zero());
  map.insert(room::scanFrom(Pose2()), Pose2());
  const Eigen::Matrix3d first = Eigen::Vector3d(1e-4, 1e-4, 1e-6).asDiagonal();
  uncertainty.add(Pose2(), first);
  EXPECT_TRUE(uncertainty.at(map.surface(), points, Pose2()).isApprox(first, 1e-6));
  // A later, less certain scan of the same walls does not change their covariance.
  map.insert(room::scanFrom(Pose2()), Pose2());
  uncertainty.add(Pose2(), 1e4 * first);
  EXPECT_TRUE(uncertainty.at(map.surface(), points, Pose2()).isApprox(first, 1e-6));
}

TEST(PoseUncertainty, ADoubtIsInThePoseAndInTheMotion) {
  constexpr double kDoubtM = 0.2;
  PoseUncertainty uncertainty;
  uncertainty.begin(Pose2());
  const Eigen::Matrix3d pose = uncertainty.last().covariance(), motion = uncertainty.motion();
  uncertainty.doubt(PredictionError({kDoubtM, 0.1}));
  const Eigen::Matrix3d doubt =
      Eigen::Vector3d(kDoubtM * kDoubtM, kDoubtM * kDoubtM, 0.0).asDiagonal();
  EXPECT_TRUE(uncertainty.last().covariance().isApprox(pose + doubt, 1e-9));
  EXPECT_TRUE(uncertainty.motion().isApprox(motion + doubt, 1e-9));
}

/// A vehicle that moves within a known room.
TEST(PoseUncertainty, DoesNotGrowInAKnownPlace) {
  Mapper mapper{MapperConfig()};
  double early = 0.0, late = 0.0;
  for (int i = 0; i < 400; ++i) {
    const Pose2 pose(0.5 * std::sin(0.05 * i), 0.5 * std::cos(0.05 * i), 0.0);
    if (i == 0) mapper.reset(pose);
    PlanarScan scan = room::scanFrom(pose);
    scan.stamp = scan.time = 0.025 * i;
    const MapperResult result = mapper.process(scan);
    if (i == 200) early = result.covariance(0, 0);
    if (i == 399) late = result.covariance(0, 0);
  }
  EXPECT_GT(early, 1e-6);
  EXPECT_LT(late, 1.2 * early);
  EXPECT_LT(std::sqrt(late), 0.02);
}

/// Flies along an infinite corridor at 1 m/s with a laser of `beams` beams. Returns the last
/// result.
MapperResult flyCorridor(int beams, double seconds, bool odometry) {
  Mapper mapper{MapperConfig()};
  MapperResult result;
  constexpr double kStep = 0.1;
  for (int i = 0; i * kStep <= seconds; ++i) {
    const Pose2 truth(kStep * i, 0.0, 0.0);
    PlanarScan scan = room::scanFrom(truth, room::corridor(), beams, 20.0);
    scan.stamp = scan.time = kStep * i;
    result = mapper.process(scan, odometry ? std::optional<Pose2>(truth) : std::nullopt);
  }
  return result;
}

TEST(PoseUncertainty, AFewBeamsDoNotEndADrift) {
  // One door frame looks like another, and the floor like a door frame.
  Submap map{OccupancyGridConfig()};
  map.insert(room::scanFrom(Pose2()), Pose2());
  const Points points = hitsOf(room::scanFrom(Pose2()));
  PoseUncertainty uncertainty;
  uncertainty.begin(Pose2());
  uncertainty.insert();
  MatchResult match;
  match.covariance = Eigen::Vector3d(1e-5, 1e-5, 1e-7).asDiagonal();
  match.degenerate_direction = Eigen::Vector2d::UnitX();
  match.predicted_along = true;
  const auto sigma_after = [&](int scans) {
    constexpr double kSeconds = 0.025;
    for (int i = 0; i < scans; ++i) {
      uncertainty.update(map.surface(), points, match, kSeconds, 0.0, PredictionSource::kVelocity);
    }
    return std::sqrt(uncertainty.last().covariance()(0, 0));
  };
  match.degenerate = true;
  const double drifted = sigma_after(40);
  EXPECT_GT(drifted, 0.2);
  match.degenerate = false;
  match.constraint = 0.4 * kWeakConstraint;
  match.along_variance = 1e-4;
  EXPECT_GT(sigma_after(40), 2.0 * drifted);  // what moves along shows no speed either
  match.constraint = 2.0 * kWeakConstraint;
  match.predicted_along = false;
  match.unclear_along = true;
  EXPECT_GT(sigma_after(1), 2.0 * drifted);
  match.unclear_along = false;
  EXPECT_LT(sigma_after(1), 0.05);
}

/// One scan is matched with walls that are known well, the scan before with others: the motion
/// between both is as certain as a match of the one with the other.
TEST(PoseUncertainty, TheAgeOfTheWallsIsNoErrorOfTheMotion) {
  Submap map{OccupancyGridConfig()};
  map.insert(room::scanFrom(Pose2()), Pose2());
  const Points points = hitsOf(room::scanFrom(Pose2()));
  MatchResult match;
  match.covariance = Eigen::Vector3d(1e-5, 1e-5, 1e-7).asDiagonal();
  match.degenerate_direction = Eigen::Vector2d::UnitX();
  match.constraint = 0.2;
  double lasting = 0.0;
  const auto sigma_with = [&](auto change, PredictionSource source) {
    PoseUncertainty uncertainty;
    uncertainty.begin(Pose2());
    uncertainty.insert();
    uncertainty.update(map.surface(), points, match, 0.1, 0.0, source);
    uncertainty.insert();
    UncertainPose inserted = uncertainty.last();
    inserted.map_covariance(0, 0) += 0.5;
    MatchResult next = match;
    change(next);
    uncertainty.update(map.surface(), points, next, 0.1, 0.0, source);
    uncertainty.update(map.surface(), points, match, 0.1, 0.0, source);
    lasting = std::sqrt(uncertainty.lastingSince(inserted)(0, 0));
    return std::sqrt(uncertainty.motionSince(inserted)(0, 0));
  };
  const auto laser = PredictionSource::kVelocity;
  EXPECT_LT(sigma_with([](MatchResult&) {}, laser), 0.02);
  EXPECT_LT(lasting, 0.02);
  // What the scans between do not show for certain is not limited.
  EXPECT_GT(sigma_with([](MatchResult& next) { next.unclear_along = true; }, laser), 0.6);
  EXPECT_GT(sigma_with([](MatchResult& next) { next.ambiguous = true; }, laser), 0.6);
  EXPECT_GT(sigma_with([](MatchResult& next) { next.searched = true; }, laser), 0.6);
  EXPECT_GT(sigma_with([](MatchResult&) {}, PredictionSource::kOdometry), 0.6);
  EXPECT_GT(lasting, 0.6);
}

/// The motions between many keyframes in a known room: the errors of their matches do not add up.
TEST(PoseUncertainty, TheErrorOfAMatchDoesNotLast) {
  Mapper mapper{MapperConfig()};
  Eigen::Matrix3d motions = Eigen::Matrix3d::Zero(), lasting = motions, matches = motions;
  UncertainPose before;
  for (int i = 0; i < 400; ++i) {
    const Pose2 pose(0.5 * std::sin(0.05 * i), 0.5 * std::cos(0.05 * i), 0.01 * i);
    if (i == 0) mapper.reset(pose);
    PlanarScan scan = room::scanFrom(pose);
    scan.stamp = scan.time = 0.025 * i;
    const MapperResult result = mapper.process(scan);
    if (!result.inserted) continue;
    if (i > 0) {
      motions += rotated(result.keyframe_covariance, before.pose.yaw);
      lasting += rotated(result.lasting_covariance, before.pose.yaw);
      matches += result.uncertain.match_covariance +
                 transported(before.match_covariance,
                             result.pose.translation() - before.pose.translation());
    }
    before = result.uncertain;
  }
  EXPECT_TRUE((lasting + matches).isApprox(motions, 1e-9));
  EXPECT_LT(lasting(2, 2), 0.5 * motions(2, 2));
  EXPECT_LT(lasting(0, 0), 0.5 * motions(0, 0));
}

TEST(PoseUncertainty, GrowsAlongACorridorForAllBeamCounts) {
  for (const int beams : {360, 720, 1440}) {
    const MapperResult early = flyCorridor(beams, 3.0, true), late = flyCorridor(beams, 9.0, true);
    EXPECT_TRUE(late.match.degenerate) << beams;
    EXPECT_EQ(late.state, MatchState::kDegraded) << beams;
    EXPECT_NEAR(std::abs(late.match.degenerate_direction.x()), 1.0, 0.01) << beams;
    // The odometry error of 10 % (kOdometryError) has a constant sign, so the standard deviation
    // grows in proportion to the distance.
    EXPECT_NEAR(late.pose.x, 9.0, 0.1) << beams;
    EXPECT_NEAR(std::sqrt(early.covariance(0, 0)), 0.3, 0.05) << beams;
    EXPECT_NEAR(std::sqrt(late.covariance(0, 0)), 0.9, 0.1) << beams;
    EXPECT_NEAR(late.pose.y, 0.0, 0.01) << beams;
    EXPECT_LT(std::sqrt(late.covariance(1, 1)), 0.03) << beams;
  }
}

TEST(PoseUncertainty, WithoutMotionSensorsTheCovarianceIsNotOverconfident) {
  const MapperResult result = flyCorridor(360, 6.0, false);
  EXPECT_TRUE(result.match.degenerate);
  EXPECT_LT(std::abs(result.pose.x - 6.0), 3.0 * std::sqrt(result.covariance(0, 0)));
}

TEST(AlongError, WithoutMeasurementGrowsUpToTheLargestSpeed) {
  AlongError error;
  for (int i = 0; i < 100; ++i) error.predict(0.1, 0.0, PredictionSource::kVelocity);
  EXPECT_GT(std::sqrt(error.covariance(0, 0)), 5.0);
  for (int i = 0; i < 1000; ++i) error.predict(0.1, 0.0, PredictionSource::kVelocity);
  EXPECT_LE(std::sqrt(error.covariance(1, 1)), 3.1);
}

TEST(AlongError, AMeasurementOfThePositionAlsoShowsTheSpeed) {
  AlongError error;
  for (int i = 0; i < 100; ++i) error.predict(0.1, 0.0, PredictionSource::kVelocity);
  for (int i = 0; i < 10; ++i) {
    error.predict(0.1, 0.0, PredictionSource::kVelocity);
    error.correct(1e-4, PredictionSource::kVelocity);
  }
  EXPECT_LT(std::sqrt(error.covariance(0, 0)), 0.011);
  EXPECT_LT(std::sqrt(error.covariance(1, 1)), 0.5);
}

}  // namespace
}  // namespace kestrel
