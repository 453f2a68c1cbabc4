// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <deque>

#include "../../src/tracking/track_list.h"

namespace kestrel {
namespace {

constexpr double kSignificant = 4.0;

std::deque<TrackList::Sample> samplesAt(double (*place)(int)) {
  std::deque<TrackList::Sample> samples;
  for (int i = 0; i < 10; ++i) {
    samples.push_back({0.1 * i, {place(i), 0.0}, 0.01, {}, 1.0, 0.2});
  }
  return samples;
}

TEST(TrackMotion, StraightPathIsSignificant) {
  EXPECT_GT(TrackList::speedSignificance(samplesAt([](int i) { return 0.12 * i; })), kSignificant);
}

// The track has changed from one thing that stands to another, and no observation is missing.
TEST(TrackMotion, OneStepIsNoPath) {
  EXPECT_EQ(TrackList::speedSignificance(samplesAt([](int i) { return i < 5 ? 0.0 : 1.0; })), 0.0);
}

// One foot stands while the other is moved.
TEST(TrackMotion, SeveralStepsAreAPath) {
  EXPECT_GT(TrackList::speedSignificance(samplesAt([](int i) { return 0.6 * (i / 3); })),
            kSignificant);
}

}  // namespace
}  // namespace kestrel
