// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/labeled_objects.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

/// 20 sightings, ten per second, along x.
std::vector<LabelSighting> pathOf(long id, double speed, std::size_t points) {
  std::vector<LabelSighting> path;
  for (int i = 0; i < 20; ++i) {
    LabelSighting sighting{0.1 * i, id, "Car", {0.1 * i * speed, 3.0}, points, true, i >= 5, 40};
    if (i >= 15) sighting.track = 41;
    sighting.has_track = i >= 2;
    path.push_back(sighting);
  }
  return path;
}

TEST(LabeledObjects, TheShareOfTheTimeIsThatWithAShownTrack) {
  const auto objects = labeledObjects(pathOf(3, 5.0, 50), {});
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects[0].id, 3);
  EXPECT_EQ(objects[0].sweeps, 20U);
  EXPECT_EQ(objects[0].hidden, 3U);
  EXPECT_DOUBLE_EQ(objects[0].share(), 0.75);
  EXPECT_NEAR(objects[0].speed, 5.0, 1e-9);
  EXPECT_EQ(objects[0].tracks, (std::set<long>{40, 41}));
}

TEST(LabeledObjects, WhatIsSlowOrHardlySeenDoesNotCount) {
  EXPECT_TRUE(labeledObjects(pathOf(3, 0.9, 50), {}).empty());
  EXPECT_TRUE(labeledObjects(pathOf(3, 5.0, 9), {}).empty());
  auto both = pathOf(3, 5.0, 9);
  for (const LabelSighting& sighting : pathOf(1, 2.0, 10)) both.push_back(sighting);
  const auto objects = labeledObjects(both, {});
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects[0].id, 1);
}

TEST(LabeledObjects, TheBoxOfALabelIsTurned) {
  KittiLabel label;
  label.center << 10.0, 5.0, 0.0;
  label.size << 4.0, 2.0, 1.5;
  label.yaw = 1.5707963;
  EXPECT_TRUE(isInLabel(label, {10.0, 6.9, 0.7}, 0.0));
  EXPECT_FALSE(isInLabel(label, {11.9, 5.0, 0.0}, 0.0));
  EXPECT_FALSE(isInLabel(label, {10.0, 5.0, 0.8}, 0.0));
  EXPECT_TRUE(isInLabel(label, {10.0, 5.0, 0.8}, 0.1));
}

}  // namespace
}  // namespace kestrel
