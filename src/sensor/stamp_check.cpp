// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/stamp_check.h"

#include <cmath>

namespace kestrel {
namespace {

constexpr double kJump_s = 1.0;  // a larger difference is a jump
constexpr int kConfirming = 3;   // this many consecutive stamps after a jump must agree

}  // namespace

StampCheck::Verdict StampCheck::check(double stamp) {
  const double step = newest_ ? stamp - *newest_ : 0.0;
  if (std::abs(step) <= kJump_s) {
    agreeing_ = 0;
    if (newest_ && step <= 0.0) return Verdict::kLate;
    newest_ = stamp;
    return Verdict::kNext;
  }
  jump_ = step;
  agreeing_ = agreeing_ > 0 && std::abs(stamp - pending_) <= kJump_s ? agreeing_ + 1 : 1;
  pending_ = stamp;
  if (agreeing_ < kConfirming) return Verdict::kJump;
  agreeing_ = 0;
  newest_ = stamp;
  return step > 0.0 ? Verdict::kNext : Verdict::kSetBack;
}

}  // namespace kestrel
