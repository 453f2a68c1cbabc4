// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/merging/far_places.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

TEST(FarPlaces, APlaceBetweenTwoOthersDoesNotHideThem) {
  EXPECT_EQ(countFarPlaces({{3, 0}, {0, 0}, {6, 0}}, 5.0), 2U);
  EXPECT_EQ(countFarPlaces({{0, 0}, {6, 0}, {3, 0}}, 5.0), 2U);
}

TEST(FarPlaces, CountsThoseThatAreFarFromAllOthers) {
  EXPECT_EQ(countFarPlaces({}, 5.0), 0U);
  EXPECT_EQ(countFarPlaces({{1, 2}, {1, 2}}, 5.0), 1U);
  EXPECT_EQ(countFarPlaces({{0, 0}, {4.9, 0}}, 5.0), 1U);
  EXPECT_EQ(countFarPlaces({{0, 0}, {5, 0}, {10, 0}, {5, 6}}, 5.0), 4U);
}

}  // namespace
}  // namespace kestrel
