// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/cloud_joiner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr int kColumns = 720;              // per turn
constexpr double kColumnTime = 0.1 / 720;  // s

/// Columns of a lidar that turns ten times per second.
PointCloud columns(int first, int count, double direction = 1.0) {
  PointCloud cloud;
  cloud.stamp = 1000.0 + first * kColumnTime;
  for (int i = first; i < first + count; ++i) {
    const double azimuth = direction * 2.0 * kPi * (i + 0.5) / kColumns;
    for (const double z : {-1.0, 0.0, 1.0}) {
      cloud.points.push_back({static_cast<float>(5.0 * std::cos(azimuth)),
                              static_cast<float>(5.0 * std::sin(azimuth)), static_cast<float>(z),
                              static_cast<float>((i - first) * kColumnTime)});
    }
  }
  return cloud;
}

std::vector<PointCloud> join(CloudJoiner& joiner, std::vector<PointCloud> clouds) {
  std::vector<PointCloud> all;
  for (PointCloud& cloud : clouds) {
    for (PointCloud& ready : joiner.add(std::move(cloud))) all.push_back(std::move(ready));
  }
  for (PointCloud& ready : joiner.finish()) all.push_back(std::move(ready));
  return all;
}

TEST(AzimuthArc, FindsTheOccupiedPartOfATurn) {
  EXPECT_NEAR(azimuthArc(columns(0, kColumns)).length, 2.0 * kPi, 0.02);
  EXPECT_NEAR(azimuthArc(columns(0, kColumns / 4)).length, kPi / 2.0, 0.02);
  EXPECT_NEAR(azimuthArc(columns(0, kColumns / 4)).center, kPi / 4.0, 0.02);
  const AzimuthArc across = azimuthArc(columns(kColumns * 3 / 8, kColumns / 4));
  EXPECT_NEAR(std::abs(across.center), kPi, 0.02);
  EXPECT_EQ(azimuthArc(PointCloud()).length, 0.0);
}

TEST(CloudJoiner, JoinsThePacketsOfEachTurn) {
  for (const int count : {9, 60, 180, 360}) {
    for (const double direction : {1.0, -1.0}) {
      std::vector<PointCloud> packets;
      for (int i = 0; i * count < 5 * kColumns; ++i) {
        packets.push_back(columns(i * count, count, direction));
      }
      CloudJoiner joiner;
      const std::vector<PointCloud> turns = join(joiner, std::move(packets));
      EXPECT_TRUE(joiner.joins()) << count;
      ASSERT_EQ(turns.size(), 5U) << count << " columns per packet, direction " << direction;
      EXPECT_EQ(turns[2].points.size(), 3U * kColumns);
      EXPECT_NEAR(turns[2].stamp, 1000.2, 1e-6);
      EXPECT_NEAR(turns[2].points.back().time, 0.1, 1e-3);
    }
  }
}

TEST(CloudJoiner, CloudsOfTheSameDirectionPassThrough) {
  for (const int count : {30, 180, kColumns}) {
    std::vector<PointCloud> clouds(6, columns(100, count));
    for (std::size_t i = 0; i < clouds.size(); ++i) clouds[i].stamp += 0.1 * static_cast<double>(i);
    CloudJoiner joiner;
    EXPECT_EQ(join(joiner, clouds).size(), 6U) << count;
    EXPECT_FALSE(joiner.joins());
  }
}

TEST(CloudJoiner, FewCloudsAreNotLost) {
  CloudJoiner joiner;
  EXPECT_EQ(join(joiner, {columns(0, 60), columns(60, 60)}).size(), 2U);
}

}  // namespace
}  // namespace kestrel
