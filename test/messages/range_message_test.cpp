// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sensor_msgs/Range.h>

#include <cmath>
#include <limits>

#include "kestrel_slam/messages/sensor_messages.h"

namespace kestrel {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

sensor_msgs::Range rangeAt(double stamp, float range) {
  sensor_msgs::Range message;
  message.header.stamp = ros::Time(stamp);
  message.min_range = 0.125F;
  message.max_range = 4.0F;
  message.range = range;
  return message;
}

TEST(RangeMessage, GivesTheHeightOfTheBaseAlongTheBeam) {
  EXPECT_EQ(toHeightSample(rangeAt(2.5, 1.5F), 0.0).height_m, 1.5);
  EXPECT_EQ(toHeightSample(rangeAt(2.5, 1.5F), -0.25).height_m, 1.75);
  EXPECT_EQ(toHeightSample(rangeAt(2.5, 1.5F), 0.0).stamp, 2.5);
}

TEST(RangeMessage, RangesOutsideTheLimitsFollowRep117) {
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(toHeightSample(rangeAt(1.0, infinity), -0.25).height_m, kInfinity);
  EXPECT_EQ(toHeightSample(rangeAt(1.0, -infinity), -0.25).height_m, -kInfinity);
  EXPECT_EQ(toHeightSample(rangeAt(1.0, 4.5F), 0.0).height_m, kInfinity);
  EXPECT_EQ(toHeightSample(rangeAt(1.0, 0.0F), 0.0).height_m, -kInfinity);
  EXPECT_TRUE(std::isnan(toHeightSample(rangeAt(1.0, std::nanf("")), 0.0).height_m));
  sensor_msgs::Range unlimited = rangeAt(1.0, 4.5F);
  unlimited.min_range = unlimited.max_range = 0.0F;
  EXPECT_EQ(toHeightSample(unlimited, 0.0).height_m, 4.5);
}

}  // namespace
}  // namespace kestrel
