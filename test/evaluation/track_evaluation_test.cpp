// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/track_evaluation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "kestrel_slam/map/atomic_file.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// A vehicle that turns in place, and an object that moves along x at 1 m/s in map.
struct Case {
  Trajectory trajectory;
  std::vector<TrackRow> rows;
  std::vector<TrueObject> truth;
};

Case movingObject(double error) {
  Case result;
  for (int i = 0; i < 50; ++i) {
    const double stamp = 10.0 + 0.1 * i;
    const Pose2 pose(1.0, 2.0, 0.1 * i);
    const Eigen::Vector2d at(0.1 * i, 4.0);
    result.trajectory.push_back({stamp, pose});
    result.truth.push_back({stamp + 0.01, 1, pose.inverse() * at});
    result.rows.push_back(
        {stamp, 7, true, at + Eigen::Vector2d(0.0, error), {1.0, 0.0}, false, true});
    result.rows.push_back(
        {stamp, 8, false, at, {0.0, 0.0}, false, false});  // not shown: does not count
  }
  return result;
}

TEST(TrackEvaluation, TrackWithAKnownError) {
  const Case c = movingObject(0.2);
  const TrackEvaluation e = evaluateTracks(c.trajectory, c.rows, c.truth, {});
  EXPECT_EQ(e.all.matches, 50U);
  EXPECT_NEAR(e.all.mota(), 1.0, 1e-9);
  EXPECT_NEAR(e.all.motp(), 0.2, 1e-6);
  EXPECT_NEAR(e.position_rmse, 0.2, 1e-6);
  EXPECT_NEAR(e.identity_share, 1.0, 1e-9);
  EXPECT_NEAR(e.gospa, 0.2, 1e-6);
  // It has moved by more than 0.5 m after 0.6 s.
  EXPECT_EQ(e.moving.truths, 44U);
}

TEST(TrackEvaluation, TrackOnAHiddenObjectIsNeitherRightNorWrong) {
  Case c = movingObject(0.2);
  for (std::size_t i = 20; i < 40; ++i) c.truth[i].visible = false;
  const TrackEvaluation e = evaluateTracks(c.trajectory, c.rows, c.truth, {});
  EXPECT_EQ(e.all.truths, 30U);
  EXPECT_EQ(e.all.matches, 30U);
  EXPECT_EQ(e.all.false_tracks, 0U);
}

TEST(TrackEvaluation, InterpolatedTruthGivesTheVelocity) {
  const Case c = movingObject(0.0);
  TrackEvaluationOptions options;
  options.max_gap_s = 0.2;
  const TrackEvaluation e = evaluateTracks(c.trajectory, c.rows, c.truth, options);
  EXPECT_GT(e.speeds, 40U);
  EXPECT_LT(e.speed_rmse, 0.05);
}

TEST(TrackEvaluation, TrackOnAnObjectThatWasNotMarkedIsNotFalse) {
  Case c = movingObject(0.0);
  std::vector<TrueObject> marked;
  for (std::size_t i = 0; i < c.truth.size(); i += 3) marked.push_back(c.truth[i]);
  TrackEvaluationOptions options;
  TrackEvaluation e = evaluateTracks(c.trajectory, c.rows, marked, options);
  EXPECT_EQ(e.all.truths, marked.size());
  EXPECT_EQ(e.all.false_tracks, 0U);
  options.unmarked_s = 0.0;
  e = evaluateTracks(c.trajectory, c.rows, marked, options);
  EXPECT_GT(e.all.false_tracks, 20U);
}

TEST(TrackEvaluation, LossesAreCountedByWhatTheNearestTrackLacks) {
  Case c = movingObject(0.0);
  // Every second row is the one that is not shown. The first 6 objects have not moved yet.
  for (std::size_t i = 0; i < 50; ++i) {
    TrackRow& shown = c.rows[2 * i];
    TrackRow& other = c.rows[2 * i + 1];
    other.position.y() += 0.1;
    other.moved = true;
    if (i < 10) continue;
    shown.shown = false;
    shown.tentative = i < 15;
    shown.moved = i >= 22;
    if (i >= 31) shown.position.y() = other.position.y() = 9.0;
  }
  const TrackEvaluation e = evaluateTracks(c.trajectory, c.rows, c.truth, {});
  EXPECT_EQ(e.moving.misses, 40U);
  EXPECT_EQ(e.losses.tentative, 5U);
  EXPECT_EQ(e.losses.not_moving, 7U);
  EXPECT_EQ(e.losses.unseen, 9U);
  EXPECT_EQ(e.losses.no_track, 19U);
}

TEST(TrackEvaluation, TracksOutsideOfTheComparedViewAreIgnored) {
  Case c = movingObject(0.0);
  for (const StampedPose& scan : c.trajectory) {
    const Eigen::Vector2d behind(-3.0, 0.5);
    c.rows.push_back({scan.stamp, 9, true, scan.pose * behind, {0.0, 0.0}, false, true});
  }
  std::stable_sort(c.rows.begin(), c.rows.end(),
                   [](const TrackRow& a, const TrackRow& b) { return a.stamp < b.stamp; });
  TrackEvaluationOptions options;
  EXPECT_EQ(evaluateTracks(c.trajectory, c.rows, c.truth, options).all.false_tracks, 50U);
  options.min_bearing = -2.5;
  options.max_bearing = 2.5;
  EXPECT_EQ(evaluateTracks(c.trajectory, c.rows, c.truth, options).all.false_tracks, 0U);
}

TEST(TrackEvaluation, NothingToCompareIsAnError) {
  const Case c = movingObject(0.0);
  EXPECT_THROW(evaluateTracks({}, c.rows, c.truth, {}), std::runtime_error);
  EXPECT_THROW(evaluateTracks(c.trajectory, c.rows, {}, {}), std::runtime_error);
  EXPECT_THROW(evaluateTracks(c.trajectory, c.rows, {{99.0, 1, {0, 0}}}, {}), std::runtime_error);
}

TEST(TrackFile, WrittenTracksAreRead) {
  TrackFrame frame;
  frame.stamp = 1.25;
  Track track;
  track.id = 3;
  track.state = TrackState::kConfirmed;
  track.moved = true;
  track.position = {1.5, -2.5};
  track.velocity = {0.5, 0.25};
  frame.tracks = {track};
  track.id = 4;
  track.moved = false;
  frame.tracks.push_back(track);
  TemporaryFolder folder;
  const std::string path = folder.file("tracks.csv");
  writeFileAtomically(path, tracksCsv({frame}));
  const std::vector<TrackRow> rows = readTracks(path);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].id, 3);
  EXPECT_TRUE(rows[0].shown);
  EXPECT_FALSE(rows[1].shown);
  EXPECT_TRUE(rows[0].moved);
  EXPECT_FALSE(rows[1].moved);
  EXPECT_FALSE(rows[0].tentative);
  EXPECT_NEAR(rows[0].stamp, 1.25, 1e-9);
  EXPECT_NEAR(rows[0].position.y(), -2.5, 1e-9);
  EXPECT_NEAR(rows[0].velocity.y(), 0.25, 1e-9);
  const auto json = nlohmann::json::parse(tracksJson({frame}));
  ASSERT_EQ(json["tracks"].size(), 1U);
  EXPECT_EQ(json["tracks"][0]["id"], 3);
}

TEST(TrackFile, BrokenLineIsNamed) {
  TemporaryFolder folder;
  const std::string path = folder.file("tracks.csv");
  writeFileAtomically(path, tracksCsv({}) + "1,2,3\n");
  try {
    readTracks(path);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find(":2: expected 23 fields, found 3"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace kestrel
