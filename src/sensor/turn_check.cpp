// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/turn_check.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr double kDelayStep = 0.05;  // s
constexpr int kDelaySteps = 10;      // each side
constexpr std::size_t kMostWaiting = 100;
const double kSmallestTurn = degToRad(1.5);  // smaller turns of a scan are inaccurate
constexpr double kMostTurn = 1e3;     // rad; larger ones are differences across a gap of the IMU
constexpr double kKeptTurns = 0.97;   // weight of the old turns: about 33 turns count
constexpr int kFewestTurns = 8;       // turns before a verdict
constexpr double kPath = 0.7;         // rad; before a verdict
constexpr double kTurnAligned = 0.8;  // correlation
/// A sensor does not turn if it shows less of the large turns of the scans. Small ones may be an
/// effect of a motion close to walls.
const double kLarge = degToRad(4.0);
constexpr double kNoTurnShare = 0.1;
constexpr double kTurnTolerance = 0.4;  // the turns of the scans are less accurate than a gyro
/// A delay is certain if the turns fit this well with it, and much worse without it.
constexpr double kDelayFit = 0.95, kDelayGain = 2.0;
constexpr double kFewestForDelay = 20;
constexpr double kSmallDelay = 0.1;  // s; smaller delays are not certain

double delayOf(std::size_t index) {
  return kDelayStep * (static_cast<double>(index) - kDelaySteps);
}

}  // namespace

double TurnCheck::Sums::correlation() const {
  const double size = std::sqrt(other_squares * scan_squares);
  return size > 0.0 ? products / size : 0.0;
}

void TurnCheck::add(double from, double to, double turn) {
  waiting_.push_back({from, to, turn});
  if (waiting_.size() > kMostWaiting) waiting_.pop_front();
}

void TurnCheck::compare(double newest, const YawAt& yaw) {
  const double latest = newest - kDelayStep * kDelaySteps;
  for (; !waiting_.empty() && waiting_.front().to <= latest; waiting_.pop_front()) {
    use(waiting_.front(), yaw);
    judge();
  }
}

void TurnCheck::use(const Turn& turn, const YawAt& yaw) {
  sums_.resize(2 * kDelaySteps + 1);
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const std::optional<double> from = yaw(turn.from + delayOf(i)), to = yaw(turn.to + delayOf(i));
    if (!from || !to) continue;
    const double other = *to - *from;
    if (std::max(std::abs(other), std::abs(turn.turn)) < kSmallestTurn) continue;
    if (std::abs(other) > kMostTurn) continue;
    Sums& sums = sums_[i];
    for (double* sum : {&sums.other_squares, &sums.scan_squares, &sums.products, &sums.path,
                        &sums.large, &sums.other_at_large}) {
      *sum *= kKeptTurns;
    }
    ++sums.pairs;
    sums.other_squares += other * other;
    sums.scan_squares += turn.turn * turn.turn;
    sums.products += other * turn.turn;
    sums.path += std::abs(turn.turn);
    if (std::abs(turn.turn) < kLarge) continue;
    sums.large += std::abs(turn.turn);
    sums.other_at_large += std::abs(other);
  }
}

void TurnCheck::judge() {
  const auto fit = [](const Sums& sums) { return std::abs(sums.correlation()); };
  const auto best = std::max_element(sums_.begin(), sums_.end(),
                                     [&](const Sums& a, const Sums& b) { return fit(a) < fit(b); });
  if (best == sums_.end() || best->pairs < kFewestTurns || best->path < kPath) return;
  const double factor = std::sqrt(best->other_squares / std::max(best->scan_squares, 1e-12));
  const double degrees = radToDeg(1.0);
  if (best->large > kPath && best->other_at_large < kNoTurnShare * best->large) {
    verdict_ = RotationVerdict::kFirstZero;
  } else if (fit(*best) < kTurnAligned) {
    return;
  } else if (std::abs(factor - degrees) < kTurnTolerance * degrees) {
    verdict_ = RotationVerdict::kDegrees;
  } else if (factor > 0.5 && factor < 2.0) {
    verdict_ = best->products > 0.0 ? RotationVerdict::kAgree : RotationVerdict::kOpposite;
    judgeDelay(static_cast<std::size_t>(best - sums_.begin()));
  }
}

/// A delay shows only while the turn rate changes.
void TurnCheck::judgeDelay(std::size_t best) {
  const Sums &with = sums_[best], &without = sums_[kDelaySteps];
  if (verdict_ != RotationVerdict::kAgree || with.pairs < kFewestForDelay) return;
  const double fit = with.correlation();
  const bool is_better = 1.0 - without.correlation() > kDelayGain * (1.0 - fit) + (1.0 - kDelayFit);
  const bool is_clear = fit > kDelayFit && std::abs(delayOf(best)) >= kSmallDelay && is_better;
  if (is_clear) {
    delay_ = delayOf(best);
  } else if (std::abs(delayOf(best)) < kSmallDelay) {
    delay_.reset();
  }
}

}  // namespace kestrel
