// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/scan_joiner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr double kFullTurn = 2.0 * kPi;
constexpr double kMostOfTurn = 0.9;  // share of a turn; a segment covers less

/// How far a beam at `angle` is from `start` in the direction of `increment`, 0 to 2 pi.
double turnedFrom(double start, double angle, double increment) {
  const double turned = std::remainder(increment < 0.0 ? start - angle : angle - start, kFullTurn);
  // Half a beam of tolerance, so that rounding does not make a full turn of zero.
  return turned < -0.5 * std::abs(increment) ? turned + kFullTurn : turned;
}

}  // namespace

ScanJoiner::Place ScanJoiner::placeOf(const LaserScan& scan) {
  return {scan.stamp, scan.angle_min, scan.angle_increment, scan.ranges.size()};
}

bool ScanJoiner::coversTurn(const Place& place) {
  return std::abs(place.angle_increment) * static_cast<double>(place.beams) >=
         kMostOfTurn * kFullTurn;
}

bool ScanJoiner::hasIncrement(const Place& place, double increment) {
  constexpr double kSame = 0.01;
  return std::abs(place.angle_increment - increment) <= kSame * std::abs(increment);
}

bool ScanJoiner::continues(const Place& first, const Place& second) {
  constexpr double kMinIncrement = 1e-5;  // rad; with a smaller one a turn needs too much memory
  constexpr double kMaxGapBeams = 1.5, kMaxPause_s = 1.0;
  const double step = first.angle_increment;
  const bool usable = std::isfinite(first.angle_min) && std::isfinite(second.angle_min) &&
                      first.beams > 0 && second.beams > 0 && std::abs(step) > kMinIncrement;
  if (!usable || coversTurn(first) || coversTurn(second) || !hasIncrement(second, step)) {
    return false;
  }
  const double pause = second.stamp - first.stamp;
  if (!(pause >= 0.0 && pause < kMaxPause_s)) return false;
  const double span = step * static_cast<double>(first.beams);
  const double moved = std::remainder(second.angle_min - first.angle_min, kFullTurn);
  const double gap = std::remainder(moved - span, kFullTurn);
  return std::abs(gap) <= kMaxGapBeams * std::abs(step) && std::abs(moved) > std::abs(span) / 2.0;
}

std::vector<LaserScan> ScanJoiner::add(LaserScan scan) {
  std::vector<LaserScan> ready;
  const Place place = placeOf(scan);
  if (last_ && continues(*last_, place)) learn(*last_, place);
  if (joins_ && isSegment(place)) {
    addSegment(std::move(scan), ready);
  } else if (!last_ && !coversTurn(place)) {
    waiting_ = std::move(scan);
  } else {
    releaseAll(ready);
    ready.push_back(std::move(scan));
  }
  last_ = place;
  return ready;
}

/// Remembers what two adjacent segments tell.
void ScanJoiner::learn(const Place& first, const Place& second) {
  joins_ = true;
  increment_ = first.angle_increment;
  seconds_per_beam_ = (second.stamp - first.stamp) / static_cast<double>(first.beams);
  if (waiting_) startTurn(std::move(*std::exchange(waiting_, std::nullopt)));
}

bool ScanJoiner::isSegment(const Place& place) const {
  return std::isfinite(place.angle_min) && std::isfinite(place.stamp) && place.beams > 0 &&
         hasIncrement(place, increment_) && !coversTurn(place);
}

void ScanJoiner::addSegment(LaserScan segment, std::vector<LaserScan>& ready) {
  if (const std::optional<std::size_t> index = indexInTurn(segment)) {
    extendTurn(segment, *index);
  } else {
    releaseAll(ready);
    startTurn(std::move(segment));
  }
  if (turn_->ranges.size() >= beams_per_turn_) releaseAll(ready);
}

std::vector<LaserScan> ScanJoiner::finish() {
  std::vector<LaserScan> ready;
  if (turn_ && 2 * turn_->ranges.size() < beams_per_turn_) {
    ++incomplete_;
    turn_.reset();
  }
  releaseAll(ready);
  return ready;
}

/// The index of the segment's first beam in the current turn; nothing if it belongs to another one.
std::optional<std::size_t> ScanJoiner::indexInTurn(const LaserScan& segment) const {
  if (!turn_) return std::nullopt;
  const double turned = turnedFrom(turn_->angle_min, segment.angle_min, increment_);
  const double index = std::max(0.0, std::round(turned / std::abs(increment_)));
  const auto result = static_cast<std::size_t>(index);
  if (result <= last_index_ || result >= beams_per_turn_) return std::nullopt;
  // After a pause the laser has turned further than the angles show.
  const double late = segment.stamp - turn_->stamp - index * seconds_per_beam_;
  const double period = static_cast<double>(beams_per_turn_) * seconds_per_beam_;
  if (std::abs(late) > period / 2.0 && seconds_per_beam_ > 0.0) return std::nullopt;
  return result;
}

void ScanJoiner::startTurn(LaserScan segment) {
  beams_per_turn_ = static_cast<std::size_t>(std::lround(kFullTurn / std::abs(increment_)));
  last_index_ = 0;
  turn_ = std::move(segment);
}

void ScanJoiner::extendTurn(const LaserScan& segment, std::size_t index) {
  std::vector<float>& ranges = turn_->ranges;
  const std::size_t end = std::min(index + segment.ranges.size(), beams_per_turn_);
  ranges.resize(std::max(ranges.size(), end), std::numeric_limits<float>::quiet_NaN());
  std::copy(segment.ranges.begin(),
            segment.ranges.begin() + static_cast<std::ptrdiff_t>(end - index),
            ranges.begin() + static_cast<std::ptrdiff_t>(index));
  last_index_ = index;
  if (turn_->time_increment == 0.0) turn_->time_increment = seconds_per_beam_;
}

void ScanJoiner::releaseAll(std::vector<LaserScan>& scans) {
  for (std::optional<LaserScan>* scan : {&waiting_, &turn_}) {
    if (*scan) scans.push_back(std::move(**scan));
    scan->reset();
  }
}

}  // namespace kestrel
