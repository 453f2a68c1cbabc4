// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

namespace kestrel {

/// Tells late readings from single wrong stamps, and those from a clock that was set.
class StampCheck {
 public:
  enum class Verdict {
    kNext,    ///< newer than all before
    kLate,    ///< a little older than the newest: it came out of order, or twice
    kJump,    ///< far from all before: not to be used
    kSetBack  ///< the last of several far back that agree: the clock was set
  };

  /// `stamp`: finite, s. Where the verdict is kNext or kSetBack, it is the newest from now on.
  Verdict check(double stamp);

  /// The jump of the last stamp that was kJump or kSetBack, s.
  double jump() const { return jump_; }
  void restart() { *this = StampCheck(); }

 private:
  std::optional<double> newest_;
  double pending_ = 0.0;  ///< the last stamp that jumped
  int agreeing_ = 0;      ///< jumped stamps in a row that agree with each other
  double jump_ = 0.0;
};

}  // namespace kestrel
