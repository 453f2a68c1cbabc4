// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/time_base.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace kestrel {
namespace {

std::vector<double> repairAll(const std::vector<double>& stamps) {
  MonotoneTime monotone;
  std::vector<double> times;
  for (const double stamp : stamps) times.push_back(monotone.repair(stamp));
  return times;
}

bool strictlyMonotone(const std::vector<double>& times) {
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (!(times[i] > times[i - 1])) return false;
  }
  return true;
}

/// Stamps with a period of 0.1 s.
std::vector<double> evenStamps(std::size_t count, double start) {
  std::vector<double> stamps;
  for (std::size_t i = 0; i < count; ++i) stamps.push_back(start + 0.1 * static_cast<double>(i));
  return stamps;
}

TEST(MonotoneTime, KeepsGoodStamps) {
  std::vector<double> stamps = evenStamps(50, 976052857.0);
  stamps.push_back(stamps.back() + 0.001);
  stamps.push_back(stamps.back() + 20.0);
  MonotoneTime monotone;
  for (const double stamp : stamps) EXPECT_EQ(monotone.repair(stamp), stamp);
  EXPECT_EQ(monotone.repaired(), 0U);
}

TEST(MonotoneTime, ContinuesEvenlyAfterALateStamp) {
  std::vector<double> stamps = evenStamps(60, 100.0);
  stamps[40] -= 0.35;
  const std::vector<double> times = repairAll(stamps);
  EXPECT_TRUE(strictlyMonotone(times));
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    EXPECT_NEAR(times[i], 100.0 + 0.1 * static_cast<double>(i), 0.02) << i;
  }
  EXPECT_EQ(times[39], stamps[39]);
}

TEST(MonotoneTime, SmoothsTheStampsOfALoggerThatWritesInBursts) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> delay(0.0, 0.9);
  std::vector<double> stamps = evenStamps(3000, 0.0);
  for (double& stamp : stamps) stamp += delay(random);
  const std::vector<double> times = repairAll(stamps);
  ASSERT_TRUE(strictlyMonotone(times));
  for (std::size_t i = 1000; i < times.size(); ++i) {
    EXPECT_NEAR(times[i] - times[i - 1], 0.1, 0.05) << i;
    EXPECT_NEAR(times[i], 0.45 + 0.1 * static_cast<double>(i), 0.5) << i;
  }
}

TEST(MonotoneTime, IgnoresASingleJumpOfAnHour) {
  for (const double jump : {3600.0, -3600.0}) {
    std::vector<double> stamps = evenStamps(60, 10000.0);
    const std::vector<double> good = stamps;
    stamps[40] += jump;
    const std::vector<double> times = repairAll(stamps);
    for (std::size_t i = 0; i < good.size(); ++i) EXPECT_NEAR(times[i], good[i], 1e-6) << i;
  }
}

TEST(MonotoneTime, RemovesTheGapOfAPermanentJump) {
  for (const double jump : {3600.0, -3600.0}) {
    const std::vector<double> good = evenStamps(60, 10000.0);
    std::vector<double> stamps = good;
    for (std::size_t i = 40; i < stamps.size(); ++i) stamps[i] += jump;
    const std::vector<double> times = repairAll(stamps);
    for (std::size_t i = 0; i < good.size(); ++i) EXPECT_NEAR(times[i], good[i], 1e-6) << i;
  }
}

TEST(MonotoneTime, ContinuesWhenABagIsPlayedAgain) {
  const std::vector<double> once = evenStamps(200, 500.0);
  std::vector<double> stamps;
  for (int loop = 0; loop < 3; ++loop) stamps.insert(stamps.end(), once.begin(), once.end());
  const std::vector<double> times = repairAll(stamps);
  const std::vector<double> expected = evenStamps(600, 500.0);
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(times[i], expected[i], 1e-3) << i;
}

TEST(MonotoneTime, IsMonotoneForArbitraryStamps) {
  std::mt19937 random(2);
  std::vector<double> stamps = {std::numeric_limits<double>::quiet_NaN(),
                                std::numeric_limits<double>::infinity(),
                                0.0,
                                0.0,
                                0.0,
                                -1e9,
                                1e18,
                                1e18,
                                5.0};
  std::uniform_real_distribution<double> exponent(-5.0, 12.0);
  for (int i = 0; i < 5000; ++i) {
    stamps.push_back((i % 3 == 0 ? -1.0 : 1.0) * std::pow(10.0, exponent(random)));
  }
  const std::vector<double> times = repairAll(stamps);
  EXPECT_TRUE(strictlyMonotone(times));
  for (const double time : times) EXPECT_TRUE(std::isfinite(time));
}

/// One stamp of a source, in the order of arrival.
struct Arrival {
  double stamp;
  std::string source;
};

/// Two lasers for 20 s, in the order of their stamps.
std::vector<Arrival> twoLasers(double period, double other_period, double other_start) {
  std::vector<Arrival> arrivals;
  for (int i = 0; i * period < 20.0; ++i) arrivals.push_back({1e9 + i * period, "front"});
  for (int i = 0; other_start + i * other_period < 20.0; ++i) {
    arrivals.push_back({1e9 + other_start + i * other_period, "back"});
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.stamp < b.stamp; });
  return arrivals;
}

TEST(TimeBase, StampsOfTwoLasersAreNotChanged) {
  for (const double other_period : {0.025, 0.1}) {  // the same rate; 40 Hz beside 10 Hz
    for (const double other_start : {0.0, 0.01}) {  // equal and different stamps
      TimeBase times;
      for (const Arrival& arrival : twoLasers(0.025, other_period, other_start)) {
        EXPECT_EQ(times.repair(arrival.source, arrival.stamp), arrival.stamp);
      }
      EXPECT_EQ(times.repaired(), 0U);
    }
  }
}

TEST(TimeBase, RepeatedStampsOfOneSourceAreRepaired) {
  TimeBase times;
  double last = 0.0;
  for (int i = 0; i < 100; ++i) {
    times.repair("front", 1e9 + 0.025 * i);
    const double time = times.repair("back", 1e9 + 0.1 * (i / 2 * 2));  // each stamp twice
    EXPECT_GT(time, last);
    last = time;
  }
  EXPECT_GT(times.repaired(), 40U);
}

TEST(TimeBase, ANewSourceHasTheClockOfTheOthers) {
  TimeBase times;
  for (int i = 0; i < 50; ++i) times.repair("front", 1e9 + 0.1 * i);
  for (int i = 50; i < 100; ++i) times.repair("front", 1e9 - 3600.0 + 0.1 * i);
  EXPECT_NEAR(times.repair("back", 1e9 - 3600.0 + 10.0), 1e9 + 10.0, 1e-3);
}

TEST(TimeBase, ManySourcesDoNotFillTheMemory) {
  TimeBase times;
  for (int i = 0; i < 10000; ++i) {
    EXPECT_TRUE(std::isfinite(times.repair("frame" + std::to_string(i), 1e9 + 0.1 * i)));
  }
}

}  // namespace
}  // namespace kestrel
