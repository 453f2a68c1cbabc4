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
  MapperResult two_places = resultOf(MatchState::kDegraded);
  two_places.match.ambiguous = true;
  EXPECT_EQ(reason(two_places), "ambiguous");
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

/// A scan of the room; without hits if `covered`.
PlanarScan scanAt(int i, bool covered = false) {
  PlanarScan scan = room::scanFrom(Pose2(0.01 * i, 0.0, 0.0));
  scan.stamp = scan.time = 0.1 * i;
  for (PlanarRay& ray : scan.rays) ray.hit = ray.hit && !covered;
  return scan;
}

TEST(MatchReason, OfAMapperWhoseViewIsCovered) {
  Mapper mapper{MapperConfig()};
  const auto next = [&mapper](int i, bool covered) {
    return std::string(mapper.process(scanAt(i, covered)).reason);
  };
  EXPECT_EQ(next(0, true), "few hits") << "there is no map yet";
  EXPECT_EQ(next(1, false), "fits") << "the first scan of the map";
  for (int i = 2; i < 10; ++i) EXPECT_EQ(next(i, false), "fits");
  EXPECT_EQ(next(10, true), "carried: few hits");
  int i = 11;
  while (i < 200 && next(i, true) != "few hits") ++i;
  ASSERT_LT(i, 200) << "is lost at last";
  ++i;
  for (int n = 0; n < 10; ++n) EXPECT_EQ(next(i + n, false), "settling") << n;
  EXPECT_EQ(next(i + 10, false), "fits");
}

}  // namespace
}  // namespace kestrel
