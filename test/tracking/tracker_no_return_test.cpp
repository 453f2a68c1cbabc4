// SPDX-License-Identifier: BSD-3-Clause
// What moves, and what only seems to, between beams without return.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/tracking/tracker.h"
#include "tracking/walker_room.h"

namespace kestrel {
namespace {

constexpr float kFarRange = 8.0F;  // m, of beams without return

/// The room of the other tests with a part of the view, ahead, without returns but those of what
/// `cast` (distance along a beam from the origin at a bearing, m) tells.
template <typename Cast>
PlanarScan scanWithHole(Room& room, int number, Cast cast) {
  constexpr double kHalfHole = 0.5;  // rad
  PlanarScan scan = room.scan(number, Pose2(), {});
  for (PlanarRay& ray : scan.rays) {
    const Eigen::Vector2f along = ray.end.normalized();
    const double bearing = static_cast<double>(std::atan2(along.y(), along.x()));
    if (std::abs(bearing) > kHalfHole) continue;
    const auto range = static_cast<float>(cast(bearing));
    ray.hit = std::isfinite(range);
    ray.presumed = !ray.hit;
    ray.end = (ray.hit ? range : kFarRange) * along;
  }
  return scan;
}

/// Middle of what is seen in this scan, m; it comes into view with scan 20 at 0.8 m/s.
double middleAt(int number) { return -1.2 + 0.08 * (number - 20); }

/// The largest number of tracks that are shown at a time.
template <typename Cast>
std::size_t mostShown(Cast cast) {
  Room room;
  Random noise(3);
  Tracker tracker;
  std::size_t most = 0;
  for (int i = 0; i < 50; ++i) {
    const PlanarScan scan = scanWithHole(room, i, [&](double bearing) {
      return i < 20 ? std::numeric_limits<double>::infinity()
                    : cast(i, bearing) + 0.01 * noise.gaussian();
    });
    const auto& tracks = tracker.process(scan, Pose2()).tracks;
    const auto shown =
        std::count_if(tracks.begin(), tracks.end(), [](const Track& t) { return t.isShown(); });
    most = std::max(most, static_cast<std::size_t>(shown));
  }
  return most;
}

// A wall returns only those beams that hit it steeply enough, or that pass a gap: that part slides
// along the wall when the sensor moves.
TEST(TrackerNoReturn, VisiblePartOfAWallDoesNotMove) {
  EXPECT_EQ(mostShown([](int i, double bearing) {
              const double y = 4.0 * std::tan(bearing);
              const bool is_visible = std::abs(y - middleAt(i)) < 0.3;
              return is_visible ? 4.0 / std::cos(bearing) : std::numeric_limits<double>::infinity();
            }),
            0U);
}

TEST(TrackerNoReturn, WalkerAcrossTheViewMoves) {
  EXPECT_EQ(mostShown([](int i, double bearing) {
              const double range = castBeam({0.0, 0.0}, bearing, {{{4.0, middleAt(i)}, 0.2}});
              return range < 5.0 ? range : std::numeric_limits<double>::infinity();
            }),
            1U);
}

}  // namespace
}  // namespace kestrel
