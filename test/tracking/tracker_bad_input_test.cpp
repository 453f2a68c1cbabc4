// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "kestrel_slam/tracking/tracker.h"
#include "tracking/walker_room.h"

namespace kestrel {
namespace {

std::size_t shownIn(const Tracker::Result& result) {
  return static_cast<std::size_t>(
      std::count_if(result.tracks.begin(), result.tracks.end(),
                    [](const Track& track) { return track.isShown(); }));
}

TEST(TrackerBadInput, AfterAJumpOfThePoseNothingMoves) {
  Room room;
  Tracker tracker;
  for (int i = 0; i < 80; ++i) {
    // The vehicle stands, but its pose jumps once.
    const Pose2 claimed = i < 30 ? Pose2() : Pose2(1.5, 0.5, 0.1);
    EXPECT_EQ(shownIn(tracker.process(room.scan(i, Pose2(), {{{2.0, 1.0}, 0.1}}), claimed)), 0U)
        << i;
  }
}

TEST(TrackerBadInput, ClutterLikeRainIsBounded) {
  Room room;
  Random random(3);
  Tracker tracker;
  for (int i = 0; i < 60; ++i) {
    PlanarScan scan = room.scan(i, Pose2(), {});
    for (PlanarRay& ray : scan.rays) {
      if (random.uniform() < 0.3) ray.end *= static_cast<float>(random.uniform());
    }
    const Tracker::Result& result = tracker.process(scan, Pose2());
    EXPECT_LE(result.tracks.size(), 400U);
  }
  // What stands is still known behind the rain.
  std::size_t walls = 0;
  const PlanarScan clear = room.scan(60, Pose2(), {});
  for (const CellMotion motion : tracker.process(clear, Pose2()).motion) {
    if (motion == CellMotion::kStatic) ++walls;
  }
  EXPECT_GT(walls, clear.rays.size() * 9 / 10);
}

TEST(TrackerBadInput, FiveHundredObjectsAreBounded) {
  Room room;
  Tracker tracker;
  for (int i = 0; i < 10; ++i) tracker.process(room.scan(i, Pose2(), {}), Pose2());
  bool saturated = false;
  for (int i = 10; i < 25; ++i) {
    std::vector<Disk> crowd;
    for (int k = 0; k < 500; ++k) {
      const double angle = 0.01257 * k, range = 2.0 + 0.007 * k - 0.05 * (i - 10);
      crowd.push_back({{range * std::cos(angle), range * std::sin(angle)}, 0.01});
    }
    saturated |= tracker.process(room.scan(i, Pose2(), crowd), Pose2()).saturated;
  }
  EXPECT_TRUE(tracker.process(room.scan(25, Pose2(), {}), Pose2()).used);
}

TEST(TrackerBadInput, StartsAnewAfterALongGap) {
  Room room;
  Tracker tracker;
  const auto walker = [](int i) { return Disk{{-3.0 + 0.1 * i, 2.0}, 0.2}; };
  long last = 0;
  for (int i = 0; i < 40; ++i) {
    for (const Track& track : tracker.process(room.scan(i, Pose2(), {walker(i)}), Pose2()).tracks) {
      last = std::max(last, track.id);
    }
  }
  // Stopped, and started again 10 s later: the ids go on.
  const Tracker::Result& result = tracker.process(room.scan(140, Pose2(), {walker(0)}), Pose2());
  EXPECT_TRUE(result.used);
  for (const Track& track : result.tracks) EXPECT_GT(track.id, last);
}

/// A door of 0.9 m beside the wall, as a row of thin posts.
std::vector<Disk> doorAt(double angle) {
  std::vector<Disk> door;
  for (int k = 0; k < 30; ++k) {
    const double along = 0.03 * k;
    door.push_back({{2.0 + along * std::cos(angle), 5.8 - along * std::sin(angle)}, 0.02});
  }
  return door;
}

TEST(TrackerBadInput, SwingingDoorMakesNothingElseMove) {
  Room room;
  Tracker tracker;
  for (int i = 0; i < 500; ++i) {
    const bool swings = i >= 20 && i < 120;
    const double angle = swings ? 0.75 - 0.75 * std::cos(0.1 * (i - 20)) : 0.0;
    const Tracker::Result& result = tracker.process(room.scan(i, Pose2(), doorAt(angle)), Pose2());
    for (const Track& track : result.tracks) {
      if (!track.isShown()) continue;
      EXPECT_LT((track.position - Eigen::Vector2d(2.0, 5.8)).norm(), 1.3) << i;
    }
    if (i == 499) {
      EXPECT_EQ(shownIn(result), 0U) << "the door belongs to the wall again";
    }
  }
}

TEST(TrackerBadInput, TimeThatStandsStillOrGoesBackChangesNothing) {
  Room room;
  Tracker tracker;
  for (int i = 0; i < 30; ++i) tracker.process(room.scan(i, Pose2(), {}), Pose2());
  const double time = tracker.grid().time();
  for (int i = 29; i > 0; --i) {
    EXPECT_FALSE(tracker.process(room.scan(i, Pose2(), {}), Pose2()).used) << i;
  }
  EXPECT_EQ(tracker.grid().time(), time);
  EXPECT_TRUE(tracker.process(room.scan(30, Pose2(), {}), Pose2()).used);
}

TEST(TrackerBadInput, StartedInFlightItFindsOnlyWhatMoves) {
  Room room;
  Tracker tracker;
  std::size_t shown = 0;
  for (int i = 0; i < 60; ++i) {
    // Fast from the first scan on, among things that stand.
    const Pose2 pose(-4.0 + 0.12 * i, 1.0 * std::sin(0.05 * i), 0.05 * i);
    const Disk walker{{-3.0 + 0.1 * i, 2.5}, 0.2};
    const std::vector<Disk> disks{walker, {{2.0, -2.0}, 0.3}, {{-1.0, -2.5}, 0.05}};
    for (const Track& track : tracker.process(room.scan(i, pose, disks), pose).tracks) {
      if (!track.isShown()) continue;
      ++shown;
      EXPECT_LT((track.position - walker.center).norm(), 0.6) << i;
    }
    if (i == 30) tracker.reset();
  }
  EXPECT_GT(shown, 20U);
}

}  // namespace
}  // namespace kestrel
