// SPDX-License-Identifier: BSD-3-Clause
// People who are hidden for a time, and what stands where they are sought.

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "kestrel_slam/tracking/tracker.h"
#include "tracking/walker_room.h"

namespace kestrel {
namespace {

constexpr int kStart = 20;  ///< scan in which the walker comes

std::set<long> shownIds(const Tracker::Result& result) {
  std::set<long> ids;
  for (const Track& track : result.tracks) {
    if (track.isShown()) ids.insert(track.id);
  }
  return ids;
}

// It goes behind the pillar for 1.7 s, and turns there by 17 degrees.
TEST(TrackerHidden, WalkerWhoTurnsUnseenKeepsItsIdentity) {
  constexpr double kStep = 0.12;  // m in a scan
  for (const double corner : {-0.6, -0.5, -0.4, -0.3, -0.2}) {
    Room room;
    Tracker tracker;
    std::set<long> ids;
    int after = 0;
    for (int i = 0; i < 80; ++i) {
      std::vector<Disk> disks{{{0.0, 1.2}, 0.5}};
      const double x = -3.0 + kStep * (i - kStart), y = 2.0 + 0.3 * std::max(0.0, x - corner);
      if (i >= kStart) disks.push_back({{x, y}, 0.2});
      const std::set<long> shown = shownIds(tracker.process(room.scan(i, Pose2(), disks), Pose2()));
      ids.insert(shown.begin(), shown.end());
      if (i >= 60 && !shown.empty()) ++after;
    }
    EXPECT_EQ(ids.size(), 1U) << corner;
    EXPECT_GE(after, 18) << corner;
  }
}

// The walker stays behind a board. Then the board is gone, and between two posts, a part of a wall
// is seen where the walker could be.
TEST(TrackerHidden, WallWhereAWalkerIsSoughtDoesNotMove) {
  constexpr int kGone = 52;
  for (const double middle : {0.0, 0.1, 0.2, 0.3}) {
    Room room;
    Tracker tracker;
    for (int i = 0; i < 90; ++i) {
      std::vector<Disk> disks{{{0.0, 1.2}, 0.6}};
      if (i >= kGone) disks = {{{-0.45, 1.2}, 0.2}, {{0.45, 1.2}, 0.2}, {{middle, 3.0}, 1.0}};
      const double x = std::min(-3.0 + 0.12 * (i - kStart), -0.2);
      if (i >= kStart && i < kGone) disks.push_back({{x, 2.0}, 0.2});
      const std::set<long> shown = shownIds(tracker.process(room.scan(i, Pose2(), disks), Pose2()));
      EXPECT_TRUE(i <= kGone || shown.empty()) << middle << " " << i;
    }
  }
}

}  // namespace
}  // namespace kestrel
