// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/map/nearest_row.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace kestrel {
namespace {

constexpr float kSteps = 512.0F;
constexpr int kLongest = 19;  // the diameter of the disk around a surfel
constexpr std::uint32_t kOld = 7, kNew = 0xFFFFFFF0U;

TEST(NearestRow, AttachesExactlyTheCellsThatAreNearer) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<float> place(-9.4F, 0.4F), beside(-6.0F, 6.0F);
  std::uniform_int_distribution<int> distance(0, 0xFFFF);
  std::size_t attached = 0, kept = 0;
  for (int i = 0; i < 5000; ++i) {
    const int count = 1 + i % kLongest;
    const float x = place(random), y = beside(random);
    // A cell on either side shows that nothing outside of the row changes.
    std::vector<std::uint16_t> before(static_cast<std::size_t>(count) + 2);
    for (std::uint16_t& value : before) value = static_cast<std::uint16_t>(distance(random));
    std::vector<std::uint16_t> after = before;
    std::vector<std::uint32_t> nearest(after.size(), kOld);
    attachRow(kNew, x, y, kSteps, {after.data() + 1, nearest.data() + 1, count});
    for (std::size_t k = 0; k < after.size(); ++k) {
      const bool is_outside = k == 0 || k + 1 == after.size();
      const float ex = x + static_cast<float>(k) - 1.0F;
      const auto mine = static_cast<int>((ex * ex + y * y) * kSteps) + 1;
      const bool is_nearer = !is_outside && mine < before[k];
      // The order of the sums may change a distance by one step.
      if (!is_outside && std::abs(mine - before[k]) <= 1) continue;
      ASSERT_EQ(nearest[k], is_nearer ? kNew : kOld) << count << " cells, cell " << k;
      ASSERT_NEAR(after[k], is_nearer ? mine : before[k], is_nearer ? 1 : 0);
      ++(is_nearer ? attached : kept);
    }
  }
  EXPECT_GT(attached, 1000U);
  EXPECT_GT(kept, 1000U);
}

TEST(NearestRow, TheDiskHasTheCellsWithinItsRadius) {
  constexpr auto kWidths = halfWidthsOfDisk<9>();
  for (int row = -9; row <= 9; ++row) {
    const int width = kWidths[static_cast<std::size_t>(row + 9)];
    EXPECT_LE(width * width + row * row, 81);
    EXPECT_GT((width + 1) * (width + 1) + row * row, 81);
  }
}

}  // namespace
}  // namespace kestrel
