// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/geometry/wilson_bound.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

/// (p + z²/2n + z sqrt(p (1 - p) / n + z²/4n²)) / (1 + z²/n) with z = 2.
TEST(WilsonBound, IsLargeWhereFewCasesWereSeen) {
  EXPECT_NEAR(wilsonUpperBound(0.0, 4.0), 0.5, 1e-12);
  EXPECT_NEAR(wilsonUpperBound(0.0, 36.0), 0.1, 1e-12);
  EXPECT_NEAR(wilsonUpperBound(0.5, 12.0), 0.75, 1e-12);
  EXPECT_NEAR(wilsonUpperBound(1.0, 3.0), 1.0, 1e-12);
  EXPECT_NEAR(wilsonUpperBound(0.3, 1e9), 0.3, 1e-4);
}

}  // namespace
}  // namespace kestrel
