// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

namespace kestrel {

/// Distinguishes late readings, single wrong stamps, and a clock that was set.
class StampCheck {
 public:
  enum class Verdict {
    kNext,    ///< newer than all earlier ones
    kLate,    ///< slightly older than the newest: out of order, or sent twice
    kJump,    ///< far from all earlier ones: not to be used
    kSetBack  ///< the last of several stamps far back that agree: the clock was set back
  };

  /// Checks the next stamp (s, finite). After kNext and kSetBack it is the newest stamp.
  Verdict check(double stamp);

  /// Size of the last jump, s.
  double jump() const { return jump_; }
  void restart() { *this = StampCheck(); }

 private:
  std::optional<double> newest_;
  double pending_ = 0.0;  ///< the last stamp that jumped
  int agreeing_ = 0;      ///< number of consecutive stamps after a jump that agree
  double jump_ = 0.0;
};

}  // namespace kestrel
