// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/stamps.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kestrel {
namespace {

constexpr std::int64_t kBillion = 1000000000;
constexpr std::uint32_t kLastSecond = std::numeric_limits<std::uint32_t>::max();
/// Stamps this close to the end of ros::Time are refused: others, such as tf, add durations to
/// them.
constexpr std::uint32_t kMargin = 86400;  // s

bool isNear(const ros::Time& a, const ros::Time& b) {
  return std::abs(secondsBetween(a, b)) <= StampGate::kFarJump;
}

std::string textOf(const ros::Time& stamp) { return std::to_string(stamp.sec) + " s"; }

/// What is wrong with a stamp in itself; empty: nothing.
std::string malformation(const ros::Time& stamp) {
  if (stamp.nsec >= kBillion) {
    return "its stamp has " + std::to_string(stamp.nsec) + " nanoseconds";
  }
  if (stamp.sec > kLastSecond - kMargin) {
    return "its stamp of " + textOf(stamp) + " is at the end of ROS time (2^32 s)";
  }
  return "";
}

}  // namespace

std::int64_t nanosecondsOf(const ros::Time& time) {
  return static_cast<std::int64_t>(time.sec) * kBillion + static_cast<std::int64_t>(time.nsec);
}

double secondsBetween(const ros::Time& from, const ros::Time& to) {
  return static_cast<double>(nanosecondsOf(to) - nanosecondsOf(from)) * 1e-9;
}

ros::Time shifted(const ros::Time& time, double seconds) {
  constexpr std::int64_t kLast = static_cast<std::int64_t>(kLastSecond) * kBillion + kBillion - 1;
  const auto shift = static_cast<std::int64_t>(
      std::round(std::clamp(seconds, -2.0 * kLastSecond, 2.0 * kLastSecond) * 1e9));
  const std::int64_t sum = std::clamp<std::int64_t>(nanosecondsOf(time) + shift, 0, kLast);
  return ros::Time(static_cast<std::uint32_t>(sum / kBillion),
                   static_cast<std::uint32_t>(sum % kBillion));
}

std::string StampGate::refusal(const ros::Time& stamp, const ros::Time& now) {
  if (stamp.isZero()) return "";
  const std::string malformed = malformation(stamp);
  if (!malformed.empty()) return malformed;
  const bool confirmed = suspect_ && stamp != *suspect_ && isNear(stamp, *suspect_);
  const bool first_is_late = !last_ && !now.isZero() && secondsBetween(now, stamp) > kFarJump;
  if (!confirmed && (first_is_late || (last_ && !isNear(stamp, *last_)))) {
    suspect_ = stamp;
    return "its stamp of " + textOf(stamp) + " is far from " +
           (last_ ? "the one before (" + textOf(*last_) : "the ROS time (" + textOf(now)) +
           "); it is believed if the next one agrees";
  }
  suspect_.reset();
  last_ = stamp;
  return "";
}

}  // namespace kestrel
