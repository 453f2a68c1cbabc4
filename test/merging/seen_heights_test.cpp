// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/merging/seen_heights.h"

#include <gtest/gtest.h>

#include <limits>

namespace kestrel {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

/// So many scans at a height.
Sightings seen(int count, float height_m, bool wall) {
  return Sightings(static_cast<std::size_t>(count), Sighting{height_m, wall});
}

Sightings operator+(Sightings a, const Sightings& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

HeightVerdict verdict(const Sightings& walls, const Sightings& other) {
  return compareHeights(walls, other, SureCells());
}
bool isExplained(const Sightings& walls, const Sightings& other) {
  return verdict(walls, other) == HeightVerdict::kExplained;
}

TEST(SeenHeights, ALintelIsNoDifference) {
  const Sightings both = seen(5, 1.2F, false) + seen(9, 2.2F, true);
  EXPECT_TRUE(isExplained(both, seen(7, 1.0F, false)));
  EXPECT_TRUE(isExplained(both, seen(7, 1.0F, false) + seen(2, 2.4F, true)));
}

TEST(SeenHeights, AboveACabinetIsTheSame) {
  EXPECT_TRUE(isExplained(seen(9, 1.2F, true) + seen(5, 2.2F, false), seen(7, 2.0F, false)));
}

TEST(SeenHeights, AtEqualHeightsAWallIsADifference) {
  EXPECT_FALSE(isExplained(seen(9, 1.2F, true), seen(7, 1.2F, false)));
  const Sightings lintel = seen(5, 1.2F, false) + seen(9, 2.2F, true);
  EXPECT_FALSE(isExplained(lintel, seen(7, 1.0F, false) + seen(5, 2.3F, false)));
}

TEST(SeenHeights, ADoorThatOnlyOneVehicleSawIsADifference) {
  // It may be a lintel, or a wall: another building, in which this door is not there.
  EXPECT_FALSE(isExplained(seen(9, 2.2F, true), seen(7, 1.0F, false)));
  EXPECT_FALSE(isExplained(seen(9, 2.2F, true), seen(9, 1.0F, false) + seen(2, 2.2F, true)));
}

TEST(SeenHeights, AWallBetweenHeightsThatWereFreeIsAContradiction) {
  // The lintel that the other vehicle also saw does not hide it, and neither does one of its own.
  const Sightings door = seen(5, 1.0F, false) + seen(5, 1.6F, false) + seen(40, 2.2F, true);
  EXPECT_EQ(verdict(seen(9, 1.3F, true), door), HeightVerdict::kContradicted);
  EXPECT_EQ(verdict(seen(9, 1.3F, true) + seen(9, 2.2F, true), door), HeightVerdict::kContradicted);
  EXPECT_EQ(verdict(seen(40, 1.3F, false) + seen(9, 2.2F, true), door), HeightVerdict::kExplained);
  EXPECT_EQ(verdict(seen(9, 1.6F, true), door), HeightVerdict::kContradicted);
  EXPECT_EQ(verdict(seen(9, 1.7F, true), door), HeightVerdict::kSaysNothing);
  // Two sensors of the height may differ by so much.
  const Sightings near = seen(5, 1.0F, false) + seen(5, 2.1F, false) + seen(40, 2.2F, true);
  EXPECT_EQ(verdict(seen(9, 2.09F, true), near), HeightVerdict::kSaysNothing);
  // What is free from some height on.
  const Sightings cabinet = seen(40, 0.9F, true) + seen(5, 1.6F, false) + seen(5, 2.2F, false);
  EXPECT_EQ(verdict(seen(9, 1.9F, true), cabinet), HeightVerdict::kContradicted);
}

TEST(SeenHeights, OneBeamIsNoFreeSpace) {
  EXPECT_FALSE(isExplained(seen(1, 1.2F, false) + seen(9, 2.2F, true), seen(7, 1.0F, false)));
}

TEST(SeenHeights, UnknownHeightsOnlyCountAgainstIt) {
  const Sightings both = seen(5, 1.2F, false) + seen(9, 2.2F, true), low = seen(7, 1.0F, false);
  EXPECT_TRUE(isExplained(both + seen(5, kUnknown, false), low));
  EXPECT_FALSE(isExplained(both + seen(1, kUnknown, true), low));
  EXPECT_FALSE(isExplained(both, low + seen(5, kUnknown, false)));
  EXPECT_FALSE(isExplained(seen(9, 2.2F, true) + seen(5, kUnknown, false), low));
  EXPECT_FALSE(isExplained(seen(9, kUnknown, true), seen(9, kUnknown, false)));
}

PlanarScan scanOf(const Eigen::Vector2f& end, bool hit) {
  PlanarScan scan;
  scan.height = {1.5F, {0.1F, 0.0F}};
  scan.rays = {{Eigen::Vector2f::Zero(), end, hit}};
  return scan;
}

TEST(SeenHeights, AScanSaysWhatIsAtAPointAndAtWhichHeight) {
  const std::vector<ComparedPoint> points = {{{2.05, 0.05}}, {{3.8, 0.05}}, {{2.05, 3.0}}};
  SightingCollector collector(points, 0.1, 0.3);
  collector.add(scanOf({4.05F, 0.05F}, true), Pose2());
  ASSERT_EQ(collector.sightings()[0].size(), 1U);
  EXPECT_FALSE(collector.sightings()[0][0].wall);
  EXPECT_NEAR(collector.sightings()[0][0].height_m, 1.705F, 1e-4F);
  ASSERT_EQ(collector.sightings()[1].size(), 1U);
  EXPECT_TRUE(collector.sightings()[1][0].wall) << "so near to the wall it is the same";
  EXPECT_TRUE(collector.sightings()[2].empty());
  // What had no return may have passed glass.
  PlanarScan silent = scanOf({4.05F, 0.05F}, false);
  silent.rays[0].no_return = true;
  collector.add(silent, Pose2());
  EXPECT_EQ(collector.sightings()[0].size(), 1U);
  // From the other side: behind the vehicle.
  collector.add(scanOf({4.05F, 0.0F}, false), Pose2(4.0, 0.05, kPi));
  EXPECT_NEAR(collector.sightings()[0].back().height_m, 1.695F, 1e-4F);
}

TEST(SeenHeights, TheWallBesideAnOpeningIsNotInTheOpening) {
  PlanarScan scan = scanOf({4.0F, 0.05F}, true);
  for (const float y : {0.35F, 0.45F}) scan.rays.push_back({{0.0F, 0.0F}, {2.05F, y}, true});
  // Along y, the next wall is 0.3 m beside the point. Along x, it is across the wall.
  const std::vector<ComparedPoint> points = {{{2.05, 0.05}, {0.0, 1.0}},
                                             {{2.05, 0.05}, {1.0, 0.0}}};
  SightingCollector collector(points, 0.1, 0.3);
  collector.add(scan, Pose2());
  EXPECT_FALSE(collector.sightings()[0].at(0).wall);
  EXPECT_TRUE(collector.sightings()[1].at(0).wall);
}

}  // namespace
}  // namespace kestrel
