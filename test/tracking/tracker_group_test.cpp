// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <vector>

#include "kestrel_slam/tracking/tracker.h"
#include "tracking/walker_room.h"

namespace kestrel {
namespace {

/// The shown track that is nearest to the point, within half a meter.
const Track* shownAt(const Tracker::Result& result, const Eigen::Vector2d& point) {
  const Track* nearest = nullptr;
  double best = 0.5;
  for (const Track& track : result.tracks) {
    const double distance = (track.position - point).norm();
    if (!track.isShown() || distance > best) continue;
    best = distance;
    nearest = &track;
  }
  return nearest;
}

// The places that the first person leaves are never empty, because the next ones come there.
TEST(TrackerGroup, FirstOfAQueueIsShownWithinASecond) {
  Room room;
  Tracker tracker;
  constexpr int kStart = 20;
  int first = -1;
  for (int i = 0; i < 50 && first < 0; ++i) {
    std::vector<Disk> disks;
    const Eigen::Vector2d head(-3.0 + 0.1 * (i - kStart), 2.0);
    for (int k = 0; i >= kStart && k < 5; ++k) {
      disks.push_back({head - Eigen::Vector2d(0.7 * k, 0.0), 0.2});
    }
    const auto& result = tracker.process(room.scan(i, Pose2(), disks), Pose2());
    if (i >= kStart && shownAt(result, head) != nullptr) first = i;
  }
  EXPECT_GE(first, kStart);
  EXPECT_LE(first, kStart + 10);
}

// For a moment, somebody and a thing beside the way are one cluster. The thing neither holds the
// middle back nor gets the track.
TEST(TrackerGroup, WhatStandsBesideTheWayDoesNotHoldBackWhoPasses) {
  Room room;
  Tracker tracker;
  constexpr int kStart = 50, kEnd = 90;
  long id = -1;
  for (int i = 0; i < kEnd; ++i) {
    std::vector<Disk> disks;
    if (i >= 20) disks.push_back({{0.45, 3.0}, 0.15});  // somebody has put it there
    const Eigen::Vector2d passer(0.0, 5.5 - 0.1 * (i - kStart));
    if (i >= kStart) disks.push_back({passer, 0.15});
    const auto& result = tracker.process(room.scan(i, Pose2(), disks), Pose2());
    if (i < kStart + 15) continue;
    const Track* track = shownAt(result, passer);
    ASSERT_NE(track, nullptr) << i;
    if (id < 0) id = track->id;
    EXPECT_EQ(track->id, id) << i;
    EXPECT_LT((track->position - passer).norm(), 0.12) << i;
    EXPECT_LT((track->velocity - Eigen::Vector2d(0.0, -1.0)).norm(), 0.3) << i;
  }
}

}  // namespace
}  // namespace kestrel
