// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/series.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace kestrel {
namespace {

using Indices = std::vector<std::size_t>;

TEST(SeriesTest, ShortSeriesIsNotReduced) {
  EXPECT_EQ(minMaxIndices({}, 4), Indices{});
  EXPECT_EQ(minMaxIndices({3, 1, 2, 5}, 4), (Indices{0, 1, 2, 3}));
}

TEST(SeriesTest, KeepsTheExtremesOfEveryIntervalInOrder) {
  // Two intervals between the ends: 1 to 4 and 5 to 8.
  const std::vector<double> values = {0, 1, 9, 2, -3, 4, 4, -5, 8, 0};
  EXPECT_EQ(minMaxIndices(values, 6), (Indices{0, 2, 4, 7, 8, 9}));
}

TEST(SeriesTest, ConstantIntervalIsOnePoint) {
  EXPECT_EQ(minMaxIndices(std::vector<double>(10, 1.0), 4), (Indices{0, 1, 8, 9}));
}

TEST(SeriesTest, RandomSeriesKeepTheirRangeAndRespectTheLimit) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (const std::size_t n : {5U, 101U, 5001U, 13631U}) {
    std::vector<double> values(n);
    for (double& value : values) value = normal(random);
    for (const std::size_t limit : {4U, 5U, 100U, 5000U}) {
      const Indices indices = minMaxIndices(values, limit);
      EXPECT_LE(indices.size(), std::max<std::size_t>(limit, 4));
      EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
      EXPECT_EQ(std::adjacent_find(indices.begin(), indices.end()), indices.end());
      EXPECT_EQ(indices.front(), 0U);
      EXPECT_EQ(indices.back(), n - 1);
      const auto less = [&](std::size_t a, std::size_t b) { return values[a] < values[b]; };
      const auto [low, high] = std::minmax_element(indices.begin(), indices.end(), less);
      EXPECT_EQ(values[*low], *std::min_element(values.begin(), values.end()));
      EXPECT_EQ(values[*high], *std::max_element(values.begin(), values.end()));
    }
  }
}

TEST(SeriesTest, SpeedsOfAConstantMotion) {
  std::vector<double> times;
  std::vector<Pose2> poses;
  for (int i = 0; i < 50; ++i) {
    times.push_back(0.1 * i);
    poses.emplace_back(0.03 * i, 0.04 * i, -0.02 * i);  // 0.5 m/s, -0.2 rad/s
  }
  const Speeds speeds = speedsOf(times, poses);
  ASSERT_EQ(speeds.linear_m_s.size(), 50U);
  EXPECT_EQ(speeds.linear_m_s[0], 0.0);
  for (std::size_t i = 1; i < 50; ++i) {
    EXPECT_NEAR(speeds.linear_m_s[i], 0.5, 1e-9);
    EXPECT_NEAR(speeds.angular_rad_s[i], -0.2, 1e-9);
  }
}

TEST(SeriesTest, YawWrapAtPiIsNoJump) {
  const Speeds speeds = speedsOf({0.0, 1.0}, {Pose2(0, 0, kPi - 0.1), Pose2(0, 0, kPi + 0.1)});
  EXPECT_NEAR(speeds.angular_rad_s[1], 0.2, 1e-9);
}

TEST(SeriesTest, EqualTimesGiveFiniteSpeeds) {
  const Speeds speeds = speedsOf({1.0, 1.0}, {Pose2(0, 0, 0), Pose2(1, 0, 0)});
  EXPECT_EQ(speeds.linear_m_s, (std::vector<double>{0.0, 0.0}));
}

}  // namespace
}  // namespace kestrel
