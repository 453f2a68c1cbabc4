// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/simulation/random_office.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kestrel {
namespace {

std::size_t lintelsOf(const Place& office) {
  std::size_t count = 0;
  for (const Box& box : office.parts.boxes)
    count += box.center.z() - 0.5 * box.size.z() > 2.0 ? 1 : 0;
  return count;
}

TEST(OfficeWithDoors, HasLintelsAndDoorsBetweenRooms) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Place office = officeWithDoors(seed, OfficeChange::kNone, 1, {});
    // Six rooms. Both rooms of an inner door draw its wall.
    EXPECT_EQ(lintelsOf(office), 6U + 2U * 4U);
    EXPECT_EQ(lintelsOf(officeWithDoors(seed, OfficeChange::kDoor, 1, {})), 6U + 2U * 3U) << seed;
    EXPECT_EQ(lintelsOf(randomOffice(seed)), 0U);
  }
}

TEST(OfficeWithDoors, TheFlightIsLowAtTheDoors) {
  const Place office = officeWithDoors(1, OfficeChange::kNone, 1, {0.8, 2.5});
  double lowest = 9.0, highest = 0.0;
  for (const FlightPlan::Waypoint& waypoint : office.plan.waypoints) {
    const double z = waypoint.position.z(),
                 from_door = std::abs(std::abs(waypoint.position.y()) - 1.2);
    if (from_door < 0.6) {
      EXPECT_LT(z, 1.5);
    }
    lowest = std::min(lowest, z);
    highest = std::max(highest, z);
  }
  EXPECT_GE(lowest, 0.8);
  EXPECT_GT(highest, 2.0);
  EXPECT_LE(highest, 2.5);
}

}  // namespace
}  // namespace kestrel
