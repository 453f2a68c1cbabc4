// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/match_reason.h"

#include <gtest/gtest.h>

#include <string>

#include "room.h"

namespace kestrel {
namespace {

/// A result in the middle of known space with a good fit.
MapperResult resultOf(MatchState state, double score = 0.95) {
  MapperResult result;
  result.state = state;
  result.match.score = score;
  result.match.known = 0.9;
  return result;
}

std::string reason(const MapperResult& result) { return reasonOf(result, MapperConfig()); }

TEST(MatchReason, OfScansThatAreMatched) {
  EXPECT_EQ(reason(resultOf(MatchState::kOk)), "fits");
  EXPECT_EQ(reason(resultOf(MatchState::kDegraded)), "settling");
  EXPECT_EQ(reason(resultOf(MatchState::kDegraded, 0.5)), "poor fit");
  MapperResult corridor = resultOf(MatchState::kDegraded, 0.5);
  corridor.match.degenerate = true;
  EXPECT_EQ(reason(corridor), "direction unobservable");
  MapperResult unclear = resultOf(MatchState::kDegraded);
  unclear.match.unclear_along = true;
  EXPECT_EQ(reason(unclear), "direction unclear");
  MapperResult two_places = resultOf(MatchState::kDegraded);
  two_places.match.ambiguous = true;
  EXPECT_EQ(reason(two_places), "ambiguous");
  MapperResult floor = resultOf(MatchState::kDegraded);
  floor.match.impossible_motion = true;
  EXPECT_EQ(reason(floor), "impossible motion");
}

TEST(MatchReason, OfScansThatAreCarried) {
  MapperResult result = resultOf(MatchState::kDegraded, 0.2);
  result.carried = true;
  EXPECT_EQ(reason(result), "carried: no fit");
  result.match.known = 0.05;
  EXPECT_EQ(reason(result), "carried: new space");
  result.match.ambiguous = true;
  EXPECT_EQ(reason(result), "carried: ambiguous");
  result.blank = true;
  EXPECT_EQ(reason(result), "carried: few hits");
}

TEST(MatchReason, OfScansThatAreLost) {
  MapperResult result = resultOf(MatchState::kLost, 0.2);
  EXPECT_EQ(reason(result), "no fit");
  result.match.known = 0.05;
  EXPECT_EQ(reason(result), "new space");
  result.match.incomplete = true;
  EXPECT_EQ(reason(result), "search not finished");
  result.match.ambiguous = true;
  EXPECT_EQ(reason(result), "ambiguous");
  result.blank = true;
  EXPECT_EQ(reason(result), "few hits");
}

TEST(MatchReason, DependsOnTheConfiguration) {
  MapperConfig strict;
  strict.matcher.search_score = 0.99;
  EXPECT_STREQ(reasonOf(resultOf(MatchState::kDegraded), strict), "poor fit");
}

enum class View { kFree, kEmpty, kBlocked };

/// A scan of the room. An empty view has no hits; a blocked one has an object at 0.4 m all around.
PlanarScan scanOf(View view, int i) {
  PlanarScan scan = room::scanFrom(Pose2(0.01 * i, 0.0, 0.0));
  scan.stamp = scan.time = 0.1 * i;
  for (PlanarRay& ray : scan.rays) {
    if (view == View::kBlocked) ray = {ray.origin, 0.4F * ray.end.normalized(), true};
    ray.hit = ray.hit && view != View::kEmpty;
  }
  return scan;
}

/// Reasons that a mapper gives.
class MapperReasons : public ::testing::Test {
 protected:
  std::string next(View view) { return mapper_.process(scanOf(view, count_++)).reason; }

  void makeMap() {
    for (int i = 0; i < 10; ++i) EXPECT_EQ(next(View::kFree), "fits") << i;
  }

  /// Shows the view until the reason is given.
  bool reaches(const std::string& wanted, View view) {
    for (int i = 0; i < 100; ++i) {
      if (next(view) == wanted) return true;
    }
    return false;
  }

  Mapper mapper_{MapperConfig()};
  int count_ = 0;
};

TEST_F(MapperReasons, WithoutHits) {
  EXPECT_EQ(next(View::kEmpty), "few hits") << "there is no map yet";
  makeMap();
  EXPECT_EQ(next(View::kEmpty), "carried: few hits");
  EXPECT_TRUE(reaches("few hits", View::kEmpty));
}

TEST_F(MapperReasons, ABlockedViewIsLostAndThenSettles) {
  makeMap();
  EXPECT_EQ(next(View::kBlocked), "carried: no fit");
  EXPECT_TRUE(reaches("no fit", View::kBlocked));
  for (int i = 0; i < 10; ++i) EXPECT_EQ(next(View::kFree), "settling") << i;
  EXPECT_EQ(next(View::kFree), "fits");
}

}  // namespace
}  // namespace kestrel
