// SPDX-License-Identifier: BSD-3-Clause
// What the searches for one scan share: nothing in their results changes.
#include "kestrel_slam/matching/shared_search.h"

#include <gtest/gtest.h>

#include "../../src/matching/rough_search.h"
#include "../../src/matching/sketch.h"
#include "kestrel_slam/matching/thinned.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr std::int64_t kAllWork = 1'000'000'000;
const Pose2 kTruth(0.3, -0.2, 0.4);

struct Searched {
  Hypotheses hypotheses;
  std::vector<Pose2> sketches;
  std::int64_t work;
};

Searched search(const Submap& map, const SearchWindow& size, SharedSearch* memory) {
  const Points points = hitsOf(room::scanFrom(kTruth));
  WorkBudget budget(kAllWork);
  RoughWindow window{Pose2(), size, CorrelativeConfig(), {}, 0};
  window.memory = memory;
  Searched result;
  result.hypotheses = searchRoughly(map.surface(), points, window, budget);
  result.sketches = sketches(map.surface(), sampled(points, kSketchPoints), result.hypotheses.poses,
                             4, budget, memory);
  result.work = budget.left();
  return result;
}

void expectSame(const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].x, b[i].x);
    EXPECT_EQ(a[i].y, b[i].y);
    EXPECT_EQ(a[i].yaw, b[i].yaw);
  }
}

void expectSame(const Searched& a, const Searched& b) {
  expectSame(a.hypotheses.poses, b.hypotheses.poses);
  expectSame(a.sketches, b.sketches);
  EXPECT_EQ(a.work, b.work);
}

TEST(SharedSearch, ChangesNoResult) {
  const Submap map = room::map();
  SharedSearch memory;
  for (const SearchWindow& size : {SearchWindow{0.6, 0.52}, {1.0, 1.57}, {0.6, 0.52}, {1.0, 1.57}})
    expectSame(search(map, size, nullptr), search(map, size, &memory));
}

TEST(SharedSearch, OneImageIsEnoughForAWindowWithinAnother) {
  const Submap map = room::map();
  SharedSearch memory;
  search(map, {1.0, 1.57}, &memory);
  const std::shared_ptr<const WallImage> image = memory.image();
  ASSERT_TRUE(image);
  search(map, {1.0, 1.57}, &memory);
  search(map, {0.6, 0.52}, &memory);
  EXPECT_EQ(memory.image(), image);
  search(map, {2.0, 1.57}, &memory);
  EXPECT_NE(memory.image(), image);
}

TEST(SharedSearch, OfAnotherMapIsForgotten) {
  const Submap room = room::map();
  Submap other{OccupancyGridConfig()};
  other.insert(room::scanFrom(Pose2(0.5, 0.5, 0.0)), Pose2());
  SharedSearch memory;
  search(room, {1.0, 1.57}, &memory);
  expectSame(search(other, {1.0, 1.57}, nullptr), search(other, {1.0, 1.57}, &memory));
}

}  // namespace
}  // namespace kestrel
