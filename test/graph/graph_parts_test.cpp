// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <set>

#include "kestrel_slam/graph/composed_map.h"
#include "kestrel_slam/graph/repeated_keyframes.h"
#include "loop_world.h"

namespace kestrel {
namespace {

using loop_world::acceptedLoops;
using loop_world::Drive;

constexpr double kDrift = 0.0003;

GaussianPose2 guessAt(const Pose2& pose) {
  GaussianPose2 guess{pose, Eigen::Matrix3d::Zero()};
  guess.covariance.diagonal() << 0.25, 0.25, 0.07;
  return guess;
}

const GaussianPose2 kFarAway = guessAt(Pose2(500.0, 0.0, 0.0));

/// One lap through the ring; the first pose is the origin of the map.
class GraphParts : public ::testing::Test {
 protected:
  GraphParts() {
    Drive drive(loop_world::ring(), kDrift);
    for (const Pose2& pose : path_) drive.add(pose, first_);
    first_.finish();
  }

  SubmapGraph continued() const { return {MapperConfig(), LoopConfig(), first_.record()}; }

  /// A second flight along the path from `begin` on. Returns its largest error against the first.
  double fly(SubmapGraph& graph, double laps, const Pose2& begin = Pose2()) const {
    const std::size_t old = graph.keyframes().size();
    Drive drive(loop_world::ring(), -kDrift, begin);
    std::vector<Pose2> path = loop_world::laps(laps);
    for (const Pose2& pose : path) drive.add(pose, graph);
    graph.finish();
    double worst = 0.0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      const Pose2 truth = path_.front().between(path[i]);
      worst =
          std::max(worst, truth.between(graph.poseOf(0).between(graph.poseOf(old + i))).distance());
    }
    return worst;
  }

  std::vector<Pose2> path_ = loop_world::laps(1.3);
  SubmapGraph first_{MapperConfig(), LoopConfig()};
};

TEST_F(GraphParts, ASecondFlightIsJoinedWhereItStarts) {
  SubmapGraph graph = continued();
  graph.beginPart(guessAt(Pose2(0.3, -0.2, 0.05)));
  EXPECT_EQ(graph.mapTLocal(), Pose2());
  const double error = fly(graph, 1.3, Pose2(0.3, -0.2, 0.05));
  EXPECT_TRUE(graph.isJoined(0));
  EXPECT_LT(error, 0.25);
}

/// Nothing is near the guess, and it is not yet doubted.
constexpr double kShortLaps = 0.1;

TEST_F(GraphParts, UntilALoopJoinsThemNothingIsDrawnOverTheOldMap) {
  SubmapGraph graph = continued();
  graph.beginPart(kFarAway);
  ComposedMap map{OccupancyGridConfig()};
  map.add(graph);
  fly(graph, kShortLaps, kFarAway.mean);
  EXPECT_FALSE(graph.isJoined(0));
  EXPECT_TRUE(graph.isLocated());
  EXPECT_EQ(acceptedLoops(graph), acceptedLoops(first_));
  EXPECT_TRUE(map.isOutdated(graph));
  ComposedMap part{OccupancyGridConfig()};
  part.add(graph);
  EXPECT_TRUE(map.grid().isKnown(map.grid().cellAt({10.0F, 21.0F})));
  EXPECT_FALSE(part.grid().isKnown(part.grid().cellAt({10.0F, 21.0F})));
}

TEST_F(GraphParts, WithoutAStartTheWholeMapIsSearched) {
  SubmapGraph graph = continued();
  graph.beginPart(std::nullopt);
  const double error = fly(graph, 1.0, Pose2(40.0, 7.0, 1.0));
  EXPECT_TRUE(graph.isJoined(0));
  EXPECT_LT(error, 0.25);
}

/// As if the vehicle had been carried elsewhere before it started again.
TEST_F(GraphParts, AWrongStartIsFoundOutInTheWholeMap) {
  SubmapGraph graph = continued();
  graph.beginPart(kFarAway);
  EXPECT_LT(fly(graph, 1.0, kFarAway.mean), 0.25);
  EXPECT_TRUE(graph.isJoined(0));
}

/// Flies 30 m through another building.
void flyElsewhere(SubmapGraph& graph, const Pose2& begin) {
  std::vector<room::Segment> walls;
  loop_world::addBox(walls, -6, -2, 40, 5);
  for (const double x : {-3.0, 1.0, 7.5, 12.0, 19.0, 24.5, 31.0})
    loop_world::addBox(walls, x, 1.5, 0.8, 1.0);
  Drive drive(walls, 0.0, begin);
  for (double x = -5.0; x < 25.0; x += 0.25) drive.add(Pose2(x, 0.0, 0.0), graph);
  graph.finish();
}

TEST_F(GraphParts, AnotherBuildingIsNotFound) {
  for (const bool start_is_given : {false, true}) {
    SubmapGraph graph = continued();
    const std::size_t old = graph.keyframes().size();
    graph.beginPart(start_is_given ? std::optional(kFarAway) : std::nullopt);
    flyElsewhere(graph, kFarAway.mean);
    EXPECT_FALSE(graph.isJoined(0));
    EXPECT_TRUE(!start_is_given || graph.poseOf(old) == kFarAway.mean);
    EXPECT_EQ(graph.isLocated(), start_is_given);
  }
}

/// Found by a search in the whole map: the new part moves there.
TEST_F(GraphParts, ALoopFromElsewhereJoinsTheParts) {
  SubmapGraph graph = continued();
  graph.beginPart(kFarAway);
  const std::size_t old = graph.keyframes().size();
  fly(graph, kShortLaps, Pose2(40.0, 7.0, 1.0));
  ASSERT_FALSE(graph.isJoined(0));
  Loop loop;
  loop.anchor = 20;
  loop.query = old + 22;
  loop.anchor_T_query = {path_[20].between(path_[22]), 1e-3 * Eigen::Matrix3d::Identity()};
  loop.radius_m = 1.0;
  EXPECT_TRUE(graph.addLoop(loop));
  EXPECT_TRUE(graph.isJoined(0));
  const Pose2 truth = path_.front().between(path_[25]);
  EXPECT_LT(truth.between(graph.poseOf(old + 25)).distance(), 0.3);
}

TEST_F(GraphParts, AKnownPlaceDoesNotMakeTheGraphGrow) {
  SubmapGraph graph = continued();
  graph.beginPart(guessAt(Pose2()));
  const std::size_t old = graph.keyframes().size();
  fly(graph, 1.3);
  ASSERT_TRUE(graph.isJoined(0));
  const GraphRecord record =
      withoutRepeated(graph.record(), graph.loadedCount(), OccupancyGridConfig());
  EXPECT_GE(record.keyframes.size(), old);
  EXPECT_LE(record.keyframes.size(), old + old / 10);
  for (std::size_t i = 0; i < old; ++i)
    ASSERT_LT(record.graph.vertices[i].pose.between(first_.poseOf(i)).distance(), 0.02) << i;
  EXPECT_EQ(problemOf(record.graph), "");
}

TEST_F(GraphParts, NewPlacesStayAndStayJoined) {
  SubmapGraph half{MapperConfig(), LoopConfig()};
  Drive drive(loop_world::ring(), kDrift);
  for (const Pose2& pose : loop_world::laps(0.5)) drive.add(pose, half);
  SubmapGraph graph{MapperConfig(), LoopConfig(), half.record()};
  graph.beginPart(guessAt(Pose2()));
  const std::size_t old = graph.keyframes().size();
  fly(graph, 1.3);
  ASSERT_TRUE(graph.isJoined(0));
  const GraphRecord record = withoutRepeated(graph.record(), old, OccupancyGridConfig());
  EXPECT_GT(record.keyframes.size(), old + 80);
  EXPECT_LT(record.keyframes.size(), graph.keyframes().size());
  SubmapGraph again{MapperConfig(), LoopConfig(), record};
  EXPECT_TRUE(again.isJoined(0)) << "the loops of removed keyframes joined it";
  for (const KnownPlace& place : record.places) EXPECT_LT(place.first, place.last);
}

/// A submap may lose all keyframes but those that it shares with the one before.
TEST_F(GraphParts, SubmapsOfKeyframesThatStayHaveNumbersOfTheirOwn) {
  SubmapGraph half{MapperConfig(), LoopConfig()};
  Drive drive(loop_world::ring(), kDrift);
  for (const Pose2& pose : loop_world::laps(0.5)) drive.add(pose, half);
  const std::vector<Pose2> lap = loop_world::laps(1.2);
  for (std::size_t begin = 0; begin < 60; begin += 6) {
    SubmapGraph graph{MapperConfig(), LoopConfig(), half.record()};
    const Pose2 start = lap.front().between(lap[begin]);
    graph.beginPart(guessAt(start));
    const std::size_t old = graph.keyframes().size();
    Drive next(loop_world::ring(), kDrift, start);
    for (std::size_t i = begin; i < lap.size(); ++i) next.add(lap[i], graph);
    graph.finish();
    SubmapGraph again{MapperConfig(), LoopConfig(),
                      withoutRepeated(graph.record(), old, OccupancyGridConfig())};
    again.beginPart(guessAt(start));
    std::set<std::uint32_t> numbers;
    for (const KnownPlace& place : again.places().all())
      EXPECT_TRUE(numbers.insert(place.submap).second) << begin << ": submap " << place.submap;
  }
}

TEST_F(GraphParts, KeyframesThatAreNotJoinedAreAllKept) {
  SubmapGraph graph = continued();
  graph.beginPart(kFarAway);
  fly(graph, kShortLaps, kFarAway.mean);
  EXPECT_EQ(
      withoutRepeated(graph.record(), graph.loadedCount(), OccupancyGridConfig()).keyframes.size(),
      graph.keyframes().size());
}

}  // namespace
}  // namespace kestrel
