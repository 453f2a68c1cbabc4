// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "kestrel_slam/sensor/gyro_check.h"

namespace kestrel {

/// Compares the turns that the scans of a laser show with those of a gyro or of the odometry. Finds
/// opposite directions (a mounting that is upside down), wrong units, and stamps of different
/// clocks. Uses neither map nor matches, so it works also if these are wrong.
class TurnCheck {
 public:
  /// Yaw of the other sensor at a time (s), rad, not wrapped; only differences are used. Nothing if
  /// it is not known.
  using YawAt = std::function<std::optional<double>(double)>;

  /// Adds a turn of the vehicle between two scans, counterclockwise from above, rad. `from`, `to`:
  /// times, s.
  void add(double from, double to, double turn);
  /// Compares the turns with the other sensor. Its newest yaw is at `newest`.
  void compare(double newest, const YawAt& yaw);

  /// The other sensor compared with the scans: kDegrees, kFirstZero, kOpposite, ...
  RotationVerdict verdict() const { return verdict_; }
  /// How much later the stamps of the other sensor are than those of the scans, s. Nothing if they
  /// agree.
  std::optional<double> delay() const { return delay_; }

 private:
  struct Turn {
    double from, to, turn;
  };
  /// Sums for one assumed delay.
  struct Sums {
    int pairs = 0;
    double other_squares = 0.0, scan_squares = 0.0, products = 0.0, path = 0.0;
    double large = 0.0, other_at_large = 0.0;  ///< sums over large turns of the scans
    double correlation() const;
  };

  void use(const Turn& turn, const YawAt& yaw);
  void judge();
  void judgeDelay(std::size_t best);

  std::deque<Turn> waiting_;  ///< for the other sensor
  std::vector<Sums> sums_;    ///< by assumed delay
  RotationVerdict verdict_ = RotationVerdict::kUnknown;
  std::optional<double> delay_;
};

}  // namespace kestrel
