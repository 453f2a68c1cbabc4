// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/console.h>

#include <chrono>
#include <mutex>
#include <optional>

namespace kestrel {

/// Limits how often a message is logged. Uses wall time, because ROS time stands still while no
/// /clock arrives. Thread-safe.
class WallThrottle {
 public:
  explicit WallThrottle(double period_s) : period_(period_s) {}

  /// True at the first call, and then at most once per period.
  bool due() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (last_ && now - *last_ < period_) return false;
    last_ = now;
    return true;
  }

 private:
  using Clock = std::chrono::steady_clock;

  std::mutex mutex_;
  std::chrono::duration<double> period_;
  std::optional<Clock::time_point> last_;
};

}  // namespace kestrel

/// Logs a warning or an error at most once per `period_s` of wall time. For each place in the code.
#define KESTREL_WARN_THROTTLE(period_s, ...)              \
  do {                                                    \
    static ::kestrel::WallThrottle throttle_at(period_s); \
    if (throttle_at.due()) ROS_WARN(__VA_ARGS__);         \
  } while (false)
#define KESTREL_ERROR_THROTTLE(period_s, ...)             \
  do {                                                    \
    static ::kestrel::WallThrottle throttle_at(period_s); \
    if (throttle_at.due()) ROS_ERROR(__VA_ARGS__);        \
  } while (false)
