// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/tracking/object_clusters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace kestrel {
namespace {

constexpr double kStep = 0.01;  // rad between the beams
constexpr double kRange = 3.0;  // m of the object; behind it, nothing for 10 m

/// The objects of a scan, in which the beams from `first` to `last` hit something in one row. Of
/// these, those from `from` to `until` hit what has come into free space.
std::vector<ObjectCluster> objectsOf(int first, int last, int from, int until,
                                     const StoodBefore& stood_before = {}) {
  std::vector<GridRay<2>> rays;
  std::vector<MovingPoint> moving;
  for (int i = 0; i < 100; ++i) {
    const double bearing = kStep * (i - 50);
    const bool hits = i >= first && i <= last;
    const double range = hits ? kRange : 10.0;
    const Eigen::Vector2d end(range * std::cos(bearing), range * std::sin(bearing));
    rays.push_back({Eigen::Vector2f::Zero(), end.cast<float>(), true, false});
    const bool has_come = i >= from && i <= until;
    if (hits) moving.push_back({end, has_come, has_come, static_cast<std::size_t>(i)});
  }
  return findObjects(moving, rays, Visibility(rays), TrackerConfig(), stood_before);
}

double bearingOf(const ObjectCluster& object) {
  return std::atan2(object.observation.value.y(), object.observation.value.x());
}

// An object uncovers a post, which joins its cluster: the middle is that of the object alone.
TEST(ObjectClusters, WhatAnObjectUncoversIsNoPartOfIt) {
  const auto alone = objectsOf(45, 54, 45, 54);
  const auto beside_post = objectsOf(45, 58, 45, 54);
  ASSERT_EQ(alone.size(), 1U);
  ASSERT_EQ(beside_post.size(), 1U);
  EXPECT_NEAR(bearingOf(beside_post[0]), bearingOf(alone[0]), 1e-6);
  EXPECT_NEAR(beside_post[0].box.size.x(), alone[0].box.size.x(), 1e-6);
  EXPECT_EQ(beside_post[0].points.size(), 10U);
  EXPECT_NEAR(beside_post[0].free_share, 10.0 / 14.0, 1e-6);
}

// In space that is not known, an object is what is seen of it.
TEST(ObjectClusters, ObjectInUnknownSpaceIsTheWholeCluster) {
  const auto objects = objectsOf(45, 58, 45, 50);
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects[0].points.size(), 14U);
}

/// What is to the left of this bearing stood there before.
StoodBefore leftOf(double bearing) {
  return [bearing](const auto& points, const auto& numbers) {
    std::vector<bool> stood;
    for (const std::size_t i : numbers) {
      stood.push_back(std::atan2(points[i].y(), points[i].x()) > bearing);
    }
    return stood;
  };
}

// Neither has come into free space, but one of them was there first.
TEST(ObjectClusters, WhatStoodThereBeforeIsAnotherObject) {
  const auto alone = objectsOf(45, 54, 0, -1);
  const auto objects = objectsOf(45, 62, 0, -1, leftOf(0.045));
  ASSERT_EQ(alone.size(), 1U);
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_EQ(objects[0].points.size(), 10U);
  EXPECT_EQ(objects[1].points.size(), 8U);
  EXPECT_NEAR(bearingOf(objects[0]), bearingOf(alone[0]), 1e-6);
}

// What is left is too small to be an object.
TEST(ObjectClusters, SplitsOffNoSingleReturns) {
  const auto objects = objectsOf(45, 62, 0, -1, leftOf(-0.045));
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects[0].points.size(), 18U);
}

}  // namespace
}  // namespace kestrel
