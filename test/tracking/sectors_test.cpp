// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/tracking/sectors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kestrel_slam/geometry/random.h"

namespace kestrel {
namespace {

constexpr int kCount = 720;

TEST(Sectors, AreThoseOfTheBearingWhateverTheGuess) {
  const Sectors sectors(kCount);
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const double place = random.uniform(0.0, kCount);
    if (std::abs(place - std::round(place)) < 1e-3) continue;  // rounding decides
    const double bearing = place * 2.0 * kPi / kCount - kPi;
    const Eigen::Vector2d along =
        random.uniform(0.1, 30.0) * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
    const int guess = static_cast<int>(random.uniform(0.0, kCount));
    const int expected = static_cast<int>(place);
    EXPECT_EQ(sectors.of(along.cast<float>(), guess), expected);
    EXPECT_EQ(sectors.of(along.cast<float>(), (expected + kCount - 1) % kCount), expected);
  }
}

TEST(Sectors, DirectionOfNoLengthIsInOneOfThem) {
  const int sector = Sectors(kCount).of(Eigen::Vector2f::Zero(), kCount - 1);
  EXPECT_GE(sector, 0);
  EXPECT_LT(sector, kCount);
}

}  // namespace
}  // namespace kestrel
