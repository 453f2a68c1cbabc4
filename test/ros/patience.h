// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>

namespace kestrel {

constexpr double kPatience = 60.0;  ///< s: only a failing test waits so long

/// The time limit of a wait in a loop. Only the time in which the test runs counts: where the
/// machine stands still or its clock jumps, one round of the loop counts as `kLongestRound`.
class Patience {
 public:
  explicit Patience(double seconds = kPatience) : left_s_(seconds) {}

  /// Call it once in each round of the loop.
  bool isOver() {
    const Clock::time_point now = Clock::now();
    left_s_ -= std::min(std::chrono::duration<double>(now - last_).count(), kLongestRound);
    last_ = now;
    return left_s_ <= 0.0;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kLongestRound = 1.0;  // s

  double left_s_;
  Clock::time_point last_ = Clock::now();
};

}  // namespace kestrel
