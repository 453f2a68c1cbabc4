// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/lost_watch.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

/// Adds scans of this state at 10 Hz. Returns the number of scans until a new map should begin.
int scansUntilNewMap(LostWatch& watch, MatchState state, bool blank, int most) {
  MapperResult result;
  result.state = state;
  result.blank = blank;
  for (int i = 0; i < most; ++i) {
    if (watch.add(result, 0.1 * i)) return i;
  }
  return most;
}

TEST(LostWatch, ANewMapBeginsAfterFiveSeconds) {
  LostWatch watch;
  EXPECT_EQ(scansUntilNewMap(watch, MatchState::kLost, false, 100), 50);
}

TEST(LostWatch, NotWhileTheVehicleIsTracked) {
  LostWatch watch;
  EXPECT_EQ(scansUntilNewMap(watch, MatchState::kDegraded, false, 100), 100);
  EXPECT_EQ(scansUntilNewMap(watch, MatchState::kLost, false, 40), 40);
  EXPECT_EQ(scansUntilNewMap(watch, MatchState::kOk, false, 1), 1);
  EXPECT_EQ(scansUntilNewMap(watch, MatchState::kLost, false, 40), 40) << "counts anew";
}

TEST(LostWatch, NotWhileNothingIsSeen) {
  LostWatch watch;
  EXPECT_EQ(scansUntilNewMap(watch, MatchState::kLost, true, 100), 100);
}

}  // namespace
}  // namespace kestrel
