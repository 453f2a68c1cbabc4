// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/loop_matcher.h"

#include <gtest/gtest.h>

#include "loop_world.h"

namespace kestrel {
namespace {

/// Keyframes at true poses, the first `mapped` of them inserted into a map.
struct Scene {
  Scene(const std::vector<room::Segment>& walls, const std::vector<Pose2>& poses,
        std::size_t mapped) {
    for (const Pose2& pose : poses) {
      auto keyframe = std::make_shared<Keyframe>();
      keyframe->scan = CompactScan(room::scanFrom(pose, walls, 180).rays);
      keyframes.push_back({keyframe, 0, pose});
    }
    for (std::size_t i = 0; i < mapped; ++i)
      map.insert(keyframes[i].keyframe->planarScan(), poses[i]);
    place = {0, 0, mapped};
    query = {mapped, poses.size()};
  }

  Submap map{OccupancyGridConfig()};
  std::vector<LocalKeyframe> keyframes;
  KnownPlace place;
  LoopQuery query;
};

std::vector<Pose2> thereAndBack() {
  std::vector<Pose2> poses;
  for (double x = -2.0; x <= 1.0; x += 0.25) poses.emplace_back(x, -1.0, 0.0);
  for (double x = 0.5; x >= -1.0; x -= 0.25) poses.emplace_back(x, -0.7, kPi);
  return poses;
}

TEST(LoopMatcher, FindsAPlaceFarFromWhereItIsExpected) {
  const Scene scene(room::walls(), thereAndBack(), 13);
  const LoopMatcher matcher{MatcherConfig(), LoopConfig()};
  const Pose2 truth = scene.keyframes[scene.query.middle()].local_T_base;
  const Pose2 expected = Pose2(1.1, -0.8, truth.yaw + 0.2);
  const Loop loop = matcher.search(scene.map, scene.place, scene.keyframes, scene.query,
                                   Pose2(truth.x + 1.1, truth.y - 0.8, expected.yaw), 2.0, 0.4);
  EXPECT_EQ(loop.state, LoopState::kPending) << loop.reason;
  const Pose2 anchor = scene.keyframes[loop.anchor].local_T_base;
  EXPECT_LT((anchor * loop.anchor_T_query.mean).between(truth).distance(), 0.05);
  EXPECT_GT(loop.margin, 0.08);
  EXPECT_GT(loop.agreement, 0.9);
}

TEST(LoopMatcher, APlaceOutsideOfTheRadiusIsRefused) {
  const Scene scene(room::walls(), thereAndBack(), 13);
  const LoopMatcher matcher{MatcherConfig(), LoopConfig()};
  const Pose2 truth = scene.keyframes[scene.query.middle()].local_T_base;
  const Loop loop = matcher.search(scene.map, scene.place, scene.keyframes, scene.query,
                                   Pose2(truth.x + 3.0, truth.y, truth.yaw), 1.5, 0.4);
  EXPECT_EQ(loop.state, LoopState::kRefused);
  EXPECT_EQ(loop.reason, "it is too far away");
}

/// A square room looks the same after a quarter turn.
TEST(LoopMatcher, AnAmbiguousPlaceIsRefused) {
  const std::vector<room::Segment> walls = {
      {-3, -3, 3, -3}, {3, -3, 3, 3}, {3, 3, -3, 3}, {-3, 3, -3, -3}};
  std::vector<Pose2> poses(20, Pose2(0.0, 0.0, 0.0));
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i].x = 0.01 * static_cast<double>(i);
  const Scene scene(walls, poses, 10);
  const LoopMatcher matcher{MatcherConfig(), LoopConfig()};
  const Loop loop =
      matcher.search(scene.map, scene.place, scene.keyframes, scene.query, poses.back(), 1.5, kPi);
  EXPECT_EQ(loop.state, LoopState::kRefused);
  EXPECT_EQ(loop.reason, "it fits in several places");
}

/// A corridor: the position along it is not observable.
TEST(LoopMatcher, ACorridorIsRefused) {
  std::vector<Pose2> poses;
  for (int i = 0; i < 20; ++i) poses.emplace_back(0.25 * i, 0.0, 0.0);
  const Scene scene(room::corridor(), poses, 10);
  const LoopMatcher matcher{MatcherConfig(), LoopConfig()};
  const Loop loop =
      matcher.search(scene.map, scene.place, scene.keyframes, scene.query, poses[12], 1.5, 0.4);
  EXPECT_EQ(loop.state, LoopState::kRefused);
  EXPECT_EQ(loop.reason, "a direction is unobservable");
}

/// Most hits of the query fit, but its beams pass through a wall and a box of the place: it is
/// another room.
Scene anotherRoom() {
  std::vector<room::Segment> with_walls = room::walls();
  with_walls.push_back({1.3, -3, 1.3, 3});
  loop_world::addBox(with_walls, -1.5, 0.5, 1.0, 1.0);
  Scene scene(with_walls, thereAndBack(), 13);
  for (std::size_t i = scene.query.first; i < scene.query.last; ++i) {
    auto other = std::make_shared<Keyframe>();
    other->scan = CompactScan(room::scanFrom(scene.keyframes[i].local_T_base).rays);
    scene.keyframes[i].keyframe = other;
  }
  return scene;
}

TEST(LoopMatcher, BeamsThroughTheWallsOfThePlaceAreRefused) {
  const Scene scene = anotherRoom();
  const Pose2 truth = scene.keyframes[scene.query.middle()].local_T_base;
  const Loop loop =
      LoopMatcher(MatcherConfig(), LoopConfig())
          .search(scene.map, scene.place, scene.keyframes, scene.query, truth, 2.0, 0.4);
  EXPECT_EQ(loop.state, LoopState::kRefused);
  EXPECT_EQ(loop.reason, "its walls contradict the place");
}

TEST(LoopMatcher, BeamsOfOneScanThroughTheWallsOfThePlaceAreRefused) {
  const Scene scene = anotherRoom();
  const LoopMatcher matcher{MatcherConfig(), LoopConfig()};
  const std::size_t middle = scene.query.middle();
  const Loop loop = matcher.matchExpected(scene.map, scene.place, scene.keyframes, middle,
                                          scene.keyframes[middle].local_T_base, 0.3);
  EXPECT_EQ(loop.state, LoopState::kRefused);
  EXPECT_EQ(loop.reason, "its walls contradict the place") << loop.fit;
}

TEST(LoopMatcher, OneScanOfThePlaceIsAccepted) {
  const Scene scene(room::walls(), thereAndBack(), 13);
  const LoopMatcher matcher{MatcherConfig(), LoopConfig()};
  for (std::size_t i = scene.query.first; i < scene.query.last; ++i) {
    const Loop loop = matcher.matchExpected(scene.map, scene.place, scene.keyframes, i,
                                            scene.keyframes[i].local_T_base, 0.3);
    EXPECT_EQ(loop.state, LoopState::kAccepted) << loop.reason;
  }
}

TEST(LoopMatcher, AScanInAnotherRoomDoesNotFit) {
  Scene scene(room::walls(), thereAndBack(), 13);
  auto other = std::make_shared<Keyframe>();
  other->scan = CompactScan(
      room::scanFrom(Pose2(), {{-1, -2, 2, -1.5}, {2, -1.5, 1, 2}, {1, 2, -1, -2}}, 180).rays);
  scene.keyframes.back().keyframe = other;
  const LoopMatcher matcher{MatcherConfig(), LoopConfig()};
  const std::size_t last = scene.keyframes.size() - 1;
  const Loop loop = matcher.matchExpected(scene.map, scene.place, scene.keyframes, last,
                                          scene.keyframes[last].local_T_base, 0.3);
  EXPECT_EQ(loop.state, LoopState::kRefused);
}

TEST(LoopMatcher, AScanWithoutHitsIsRefused) {
  Scene scene(room::walls(), thereAndBack(), 13);
  auto blank = std::make_shared<Keyframe>();
  scene.keyframes.back().keyframe = blank;
  const LoopMatcher matcher{MatcherConfig(), LoopConfig()};
  const std::size_t last = scene.keyframes.size() - 1;
  const Loop loop =
      matcher.matchExpected(scene.map, scene.place, scene.keyframes, last, Pose2(), 0.3);
  EXPECT_EQ(loop.state, LoopState::kRefused);
  EXPECT_EQ(loop.reason, "too few hits");
  EXPECT_EQ(loop.query, last);
}

}  // namespace
}  // namespace kestrel
