// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

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

}  // namespace
}  // namespace kestrel
