// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {

/// Equal sectors around the sensor, the first of which begins at -pi.
class Sectors {
 public:
  explicit Sectors(int count) : count_(count) {
    for (int i = 0; i <= count; ++i) {
      const double bearing = i * 2.0 * kPi / count - kPi;
      borders_.emplace_back(Eigen::Vector2d(std::cos(bearing), std::sin(bearing)).cast<float>());
    }
  }

  /// The sector of a direction. `guess`: that of the beam before, which is the same or near.
  int of(const Eigen::Vector2f& along, int guess) const {
    constexpr int kNear = 3;  // sectors from the guess
    if (isLeftOf(guess + 1, along)) {
      for (int i = 0; i < kNear; ++i) {
        if (++guess == count_) guess = 0;
        if (!isLeftOf(guess + 1, along)) return guess;
      }
    } else {
      for (int i = 0; i <= kNear; ++i) {
        if (isLeftOf(guess, along)) return guess;
        if (--guess < 0) guess = count_ - 1;
      }
    }
    const auto bearing = static_cast<double>(std::atan2(along.y(), along.x()));
    return static_cast<int>((bearing + kPi) / (2.0 * kPi) * count_) % count_;
  }

 private:
  /// True if the direction is at most half a turn to the left of a border.
  bool isLeftOf(int border, const Eigen::Vector2f& along) const {
    const Eigen::Vector2f& b = borders_[static_cast<std::size_t>(border)];
    return b.x() * along.y() - b.y() * along.x() >= 0.0F;
  }

  int count_;
  std::vector<Eigen::Vector2f> borders_;
};

}  // namespace kestrel
