// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/stamps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace kestrel {
namespace {

constexpr std::uint32_t kLast = std::numeric_limits<std::uint32_t>::max();
const ros::Time kUnknown;  // no ROS time yet

/// Every combination of seconds and nanoseconds at the limits of their types.
std::vector<ros::Time> extremeStamps() {
  std::vector<ros::Time> stamps;
  for (const std::uint32_t sec : {0u, 1u, 1u << 31, (1u << 31) - 1, kLast - 11, kLast - 1, kLast}) {
    for (const std::uint32_t nsec : {0u, 1u, 999999999u, 1000000000u, kLast}) {
      stamps.emplace_back();
      stamps.back().sec = sec;
      stamps.back().nsec = nsec;
    }
  }
  return stamps;
}

TEST(Stamps, ArithmeticNeverThrows) {
  for (const ros::Time& a : extremeStamps()) {
    for (const ros::Time& b : extremeStamps()) {
      EXPECT_EQ(secondsBetween(a, b), -secondsBetween(b, a));
      for (const double s : {-1e300, -5e9, -1.0, 0.0, 2.0, 5e9, 1e300}) {
        EXPECT_NO_THROW(shifted(a, s));
      }
    }
  }
}

TEST(Stamps, ShiftIsExactAndLimited) {
  EXPECT_EQ(shifted(ros::Time(10, 900000000), 0.2), ros::Time(11, 100000000));
  EXPECT_EQ(shifted(ros::Time(10, 100000000), -0.2), ros::Time(9, 900000000));
  EXPECT_EQ(shifted(ros::Time(1, 0), -2.0), ros::Time(0, 0));
  EXPECT_EQ(shifted(ros::Time(kLast, 0), 2.0), ros::Time(kLast, 999999999));
  EXPECT_DOUBLE_EQ(secondsBetween(ros::Time(kLast, 0), ros::Time(1, 0)),
                   1.0 - static_cast<double>(kLast));
}

TEST(StampGate, OneWrongStampIsRefused) {
  StampGate gate;
  std::mt19937 random(1);
  for (std::uint32_t i = 0; i < 10000; ++i) {
    const ros::Time good(1700000000u + i / 10, i % 10 * 100000000);
    EXPECT_EQ(gate.refusal(good, kUnknown), "") << i;
    const auto sec = static_cast<std::uint32_t>(random());
    if (sec == 0 || std::abs(static_cast<double>(sec) - 1.7e9) < 2e5) continue;
    EXPECT_NE(gate.refusal(ros::Time(sec, 0), kUnknown), "") << sec;
  }
}

TEST(StampGate, AClockThatWasSetLosesOneMessage) {
  StampGate gate;
  EXPECT_EQ(gate.refusal(ros::Time(100, 0), kUnknown), "");
  EXPECT_NE(gate.refusal(ros::Time(1700000000, 0), kUnknown), "");
  EXPECT_EQ(gate.refusal(ros::Time(1700000000, 100), kUnknown), "");
  EXPECT_EQ(gate.refusal(ros::Time(1700000001, 0), kUnknown), "");
  EXPECT_NE(gate.refusal(ros::Time(5, 0), kUnknown), "");
  EXPECT_NE(gate.refusal(ros::Time(5, 0), kUnknown), "") << "a repeated stamp confirms nothing";
  EXPECT_EQ(gate.refusal(ros::Time(6, 0), kUnknown), "");
}

TEST(StampGate, ARecordingThatStartsAgainLosesNothing) {
  StampGate gate;
  EXPECT_EQ(gate.refusal(ros::Time(1700003600, 0), kUnknown), "");
  EXPECT_EQ(gate.refusal(ros::Time(1700000000, 0), kUnknown), "");
}

TEST(StampGate, TheFirstStampIsComparedWithTheClock) {
  StampGate gate;
  EXPECT_NE(gate.refusal(ros::Time(3000000000u, 0), ros::Time(1700000000, 0)), "");
  EXPECT_EQ(gate.refusal(ros::Time(1700000000, 0), ros::Time(1700000000, 0)), "");
  StampGate old_recording;
  EXPECT_EQ(old_recording.refusal(ros::Time(100, 0), ros::Time(1700000000, 0)), "");
}

TEST(StampGate, StampsAtTheEndOfRosTimeAreNeverBelieved) {
  StampGate gate;
  for (std::uint32_t i = 0; i < 20; ++i) {
    EXPECT_NE(gate.refusal(ros::Time(kLast - 20 + i, 0), kUnknown), "");
  }
  ros::Time odd(100, 0);
  odd.nsec = 1000000000;
  EXPECT_NE(gate.refusal(odd, kUnknown), "");
}

}  // namespace
}  // namespace kestrel
