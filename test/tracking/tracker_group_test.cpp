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

}  // namespace
}  // namespace kestrel
