// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/places.h"

#include <gtest/gtest.h>

#include "loop_world.h"

namespace kestrel {
namespace {

/// More places than fit into the cache: a grid that is built again is the same one.
TEST(Places, AGridIsBuiltAgainWhenItIsNeeded) {
  std::vector<LocalKeyframe> keyframes;
  Places places{MapperConfig()};
  const std::vector<room::Segment> walls = loop_world::ring();
  for (std::uint32_t number = 0; number < 60; ++number) {
    auto keyframe = std::make_shared<Keyframe>();
    const Pose2 pose(-10.5 + 0.3 * number, -10.5, 0.0);
    keyframe->scan = CompactScan(room::scanFrom(pose, walls, 360).rays);
    keyframes.push_back({keyframe, number, pose});
    places.add(number, number, number + 1);
  }
  const MapSnapshot first = places.mapOf(0, keyframes).grid().snapshot();
  std::size_t most = 0;
  for (std::size_t i = 0; i < places.all().size(); ++i) {
    places.mapOf(i, keyframes);
    most = std::max(most, places.memoryBytes());
  }
  EXPECT_LT(most, 18'000'000U);
  EXPECT_EQ(places.mapOf(0, keyframes).grid().snapshot().cells, first.cells);
}

}  // namespace
}  // namespace kestrel
