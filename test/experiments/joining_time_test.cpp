// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/joining_time.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

TEST(JoiningTime, VehiclesOfOneOfficeAreJoinedAfterTheyHaveSeenTheSame) {
  const SlamConfig config;
  const std::vector<MappedVehicle> vehicles = {mapOffice(1, OfficeChange::kNone, 1, config),
                                               mapOffice(1, OfficeChange::kNone, 2, config)};
  const std::vector<JoiningTime> times = measureJoining(vehicles, config, 10.0);
  ASSERT_EQ(times.size(), 1U);
  ASSERT_TRUE(times.front().seen_s);
  ASSERT_TRUE(times.front().joined_s);
  EXPECT_GE(*times.front().later(), 0.0);
  EXPECT_LT(times.front().off_m, 0.3);
}

TEST(JoiningTime, VehiclesOfTwoOfficesAreNeverJoined) {
  const SlamConfig config;
  const std::vector<MappedVehicle> vehicles = {mapOffice(1, OfficeChange::kNone, 1, config),
                                               mapOffice(2, OfficeChange::kNone, 2, config)};
  const std::vector<JoiningTime> times = measureJoining(vehicles, config, 60.0);
  ASSERT_EQ(times.size(), 1U);
  EXPECT_FALSE(times.front().seen_s);
  EXPECT_FALSE(times.front().joined_s);
  EXPECT_FALSE(times.front().later());
}

}  // namespace
}  // namespace kestrel
