// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/localizer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kestrel_slam/graph/place_finder.h"
#include "loop_world.h"

namespace kestrel {
namespace {

/// A vehicle drives counterclockwise through a ring of corridors. The upper corridor is not in the
/// map.
class HalfMappedRing : public testing::Test {
 protected:
  HalfMappedRing() {
    for (const Pose2& pose : path_) {
      if (isMapped(pose)) map_.insert(scanAt(pose), pose);
    }
  }

  static bool isMapped(const Pose2& pose) { return pose.y < 7.0; }

  /// The laser sees less far than a corridor is long.
  PlanarScan scanAt(const Pose2& pose) const { return room::scanFrom(pose, walls_, 240, 6.0); }

  MapperResult process(Localizer& localizer, std::size_t i) {
    PlanarScan scan = scanAt(path_[i]);
    scan.stamp = scan.time = time_ += 0.25;
    return localizer.process(scan);
  }

  double error(std::size_t i, const MapperResult& result) const {
    return path_[i].between(result.pose).distance();
  }

  std::size_t next(std::size_t i) const { return (i + 1) % path_.size(); }

  std::vector<room::Segment> walls_ = loop_world::ring();
  std::vector<Pose2> path_ = loop_world::laps(1.0);
  Submap map_{OccupancyGridConfig()};
  double time_ = 0.0;
};

TEST_F(HalfMappedRing, AVehicleThatLeavesTheMapIsFollowedUntilItComesBack) {
  Localizer localizer(MapperConfig(), std::move(map_));
  localizer.setPose(path_[20]);
  int outside = 0;
  MapperResult result;
  for (std::size_t i = 20; i < path_.size(); ++i) {
    result = process(localizer, i);
    EXPECT_FALSE(localizer.isLost()) << i;
    EXPECT_LT(error(i, result), isMapped(path_[i]) && i < path_.size() / 2 ? 0.05 : 0.3) << i;
    EXPECT_FALSE(result.inserted);
    outside += result.carried ? 1 : 0;
    if (result.carried) EXPECT_NE(result.state, MatchState::kOk);
  }
  EXPECT_GT(outside, 30) << "the upper corridor is not in the map";
  EXPECT_EQ(result.state, MatchState::kOk) << result.reason;
  EXPECT_LT(error(path_.size() - 1, result), 0.05);
}

TEST_F(HalfMappedRing, AVehicleThatBeginsOutsideOfTheMapIsFoundWhenItIsInTheMap) {
  Localizer localizer(MapperConfig(), std::move(map_));
  const auto outside = [&](std::size_t i) { return path_[i].y > 10.0 && path_[i].x < -6.0; };
  std::size_t i = 0;
  while (!outside(i)) ++i;
  for (; path_[i].y > 4.0; i = next(i)) {
    const MapperResult result = process(localizer, i);
    if (!localizer.isLost()) EXPECT_LT(error(i, result), 0.3) << i;
  }
  for (int step = 0; localizer.isLost() && step < 12; ++step, i = next(i)) process(localizer, i);
  const MapperResult result = process(localizer, i);
  EXPECT_FALSE(localizer.isLost());
  EXPECT_LT(error(i, result), 0.1);
}

TEST_F(HalfMappedRing, ALostVehicleSearchesLessOftenWhereNothingFits) {
  const GlobalMap global(map_);
  PlaceFinder finder(global, MatcherConfig(), RelocalizationConfig());
  std::vector<room::Segment> elsewhere;
  loop_world::addBox(elsewhere, -30, -1.9, 60, 3.8);
  for (double x = -20.0; x < 20.0; x += 2.3) loop_world::addBox(elsewhere, x, -1.9, 0.8, 0.9);
  int searches = 0;
  for (double x = -4.0; x < 0.0; x += 0.25) {
    const Pose2 pose(x, 0.3, 0.2);
    finder.add(room::scanFrom(pose, elsewhere, 240), pose);
    searches += finder.advance(4'000'000'000) ? 1 : 0;
    EXPECT_FALSE(finder.mapTLocal());
  }
  EXPECT_GE(searches, 4);
  EXPECT_LE(searches, 6) << "8 without pauses";
}

}  // namespace
}  // namespace kestrel
