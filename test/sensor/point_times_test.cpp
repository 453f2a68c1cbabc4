// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/point_times.h"

#include <gtest/gtest.h>

#include <limits>

namespace kestrel {
namespace {

constexpr double kCloudStamp = 1.7e9;  // s
constexpr double kNanosecond = 1e-9;
constexpr int kPoints = 101;

PointCloud cloudOf(int points) {
  PointCloud cloud;
  cloud.stamp = kCloudStamp;
  cloud.points.assign(static_cast<std::size_t>(points), {1.0F, 2.0F, 3.0F, 0.0F});
  return cloud;
}

/// The times of the first and the last point of a sweep of `duration_s` that begins at `begin_s` on
/// some clock, and is written in `unit`.
std::pair<double, double> timesOf(double begin_s, double duration_s, double unit, double usual) {
  PointCloud cloud = cloudOf(kPoints);
  std::vector<double> values;
  for (int i = 0; i < kPoints; ++i) values.push_back((begin_s + duration_s * i / 100.0) / unit);
  setPointTimes(values, usual, cloud);
  EXPECT_EQ(cloud.time_problem, "");
  return {cloud.points.front().time, cloud.points.back().time};
}

TEST(PointTimes, TheSpreadDecidesTheUnit) {
  for (const double usual : {1.0, kNanosecond}) {
    for (const double unit : {1.0, 1e-3, 1e-6, kNanosecond}) {
      for (const double duration : {0.03, 0.1, 0.2}) {
        const auto [first, last] = timesOf(0.0, duration, unit, usual);
        EXPECT_EQ(first, 0.0);
        EXPECT_NEAR(last, duration, 1e-6) << "unit " << unit << " usual " << usual;
      }
    }
  }
}

TEST(PointTimes, TimesOfTheClockOfTheStampAreAbsolute) {
  for (const double unit : {1.0, 1e-6, kNanosecond}) {
    const auto [first, last] = timesOf(kCloudStamp - 0.02, 0.1, unit, 1.0);
    EXPECT_NEAR(first, -0.02, 1e-4) << unit;
    EXPECT_NEAR(last, 0.08, 1e-4) << unit;
  }
}

TEST(PointTimes, TimesOfAnotherClockCountFromTheFirstPoint) {
  for (const double since_boot : {5.0, 91.0, 40000.0, kCloudStamp + 37.0}) {
    for (const double unit : {1.0, 1e-6, kNanosecond}) {
      const auto [first, last] = timesOf(since_boot, 0.1, unit, 1.0);
      EXPECT_NEAR(first, 0.0, 1e-6) << since_boot << " unit " << unit;
      EXPECT_NEAR(last, 0.1, 1e-4) << since_boot << " unit " << unit;
    }
  }
}

TEST(PointTimes, AStampAtTheEndOfTheSweepGivesNegativeTimes) {
  const auto [first, last] = timesOf(-0.1, 0.1, 1.0, 1.0);
  EXPECT_NEAR(first, -0.1, 1e-6);
  EXPECT_NEAR(last, 0.0, 1e-6);
}

TEST(PointTimes, APacketOfOneMillisecondKeepsItsUsualUnit) {
  EXPECT_NEAR(timesOf(0.0, 1.3e-3, kNanosecond, kNanosecond).second, 1.3e-3, 1e-6);
  EXPECT_NEAR(timesOf(0.0, 1.3e-3, 1.0, 1.0).second, 1.3e-3, 1e-6);
  // All returns at nearly one time of a longer sweep.
  EXPECT_NEAR(timesOf(0.05, 1e-5, kNanosecond, kNanosecond).first, 0.05, 1e-6);
}

TEST(PointTimes, ConstantAndImpossibleTimesAreNotUsedAndThisIsSaid) {
  for (const double value : {0.0, 1.7e18, 91.0}) {
    PointCloud cloud = cloudOf(kPoints);
    setPointTimes(std::vector<double>(kPoints, value), 1.0, cloud);
    EXPECT_NE(cloud.time_problem.find("all have the same time"), std::string::npos);
    for (const PointCloud::Point& point : cloud.points) EXPECT_EQ(point.time, 0.0F);
  }
  PointCloud cloud = cloudOf(2);
  setPointTimes({0.0, 1e-5}, 1.0, cloud);
  EXPECT_NE(cloud.time_problem.find("no sweep in s"), std::string::npos);
  EXPECT_EQ(cloud.points.back().time, 0.0F);
}

TEST(PointTimes, PointsWithoutReturnAndInvalidNumbersDoNotCount) {
  PointCloud cloud = cloudOf(4);
  cloud.points[0] = {0.0F, 0.0F, 0.0F, 0.0F};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  setPointTimes({0.0, 500.0, nan, 500.1}, 1.0, cloud);
  EXPECT_EQ(cloud.points[0].time, 0.0F);
  EXPECT_EQ(cloud.points[2].time, 0.0F);
  EXPECT_NEAR(cloud.points[3].time, 0.1, 1e-6);
}

}  // namespace
}  // namespace kestrel
