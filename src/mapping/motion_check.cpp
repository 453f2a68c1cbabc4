// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/motion_check.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/square.h"

namespace kestrel {
namespace {

/// The velocity is that of the last positions over this time, s, and at least of two.
constexpr double kVelocitySpan = 0.1;
/// Largest acceleration of a vehicle, and the noise of a match.
constexpr double kMostAcceleration = 9.81;  // m/s²
constexpr double kNoiseM = 0.02;
constexpr double kMatchSigmas = 3.0;  // of the errors of two lasers

}  // namespace

bool MotionCheck::isImpossible(const Entry& found) const {
  if (last_.size() < 2) return false;
  const Entry &oldest = last_.front(), &newest = last_.back();
  const double known_s = newest.time - oldest.time, seconds = found.time - newest.time;
  const Eigen::Vector2d velocity = (newest.position - oldest.position) / known_s;
  Eigen::Vector2d missed = found.position - newest.position - seconds * velocity;
  missed -= found.weak.dot(missed) * found.weak;
  for (const Entry& entry : last_) missed -= entry.weak.dot(missed) * entry.weak;
  const double accelerated = 0.5 * kMostAcceleration * seconds * (known_s + seconds);
  // A driver may deliver two scans at once. Then the stamps are wrong by this time.
  const double interval = known_s / static_cast<double>(last_.size() - 1);
  const double moved_meanwhile = velocity.norm() * std::abs(seconds - interval);
  return missed.norm() > accelerated + moved_meanwhile + noiseOf(found, missed);
}

/// How far the errors of the matches may move a position along `missed`, m.
double MotionCheck::noiseOf(const Entry& found, const Eigen::Vector2d& missed) const {
  const Entry &oldest = last_.front(), &newest = last_.back();
  const bool one_laser = std::all_of(last_.begin(), last_.end(),
                                     [&](const Entry& e) { return e.laser == found.laser; });
  if (one_laser) return kNoiseM;
  const double share = (found.time - newest.time) / (newest.time - oldest.time);
  const Eigen::Matrix2d covariance = found.covariance + square(1.0 + share) * newest.covariance +
                                     square(share) * oldest.covariance;
  const Eigen::Vector2d along = missed.normalized();
  return std::max(kNoiseM, kMatchSigmas * std::sqrt(std::max(0.0, along.dot(covariance * along))));
}

void MotionCheck::add(const Entry& found) {
  if (!last_.empty() && found.time <= last_.back().time) last_.clear();
  last_.push_back(found);
  while (last_.size() > 2 && found.time - last_.front().time > kVelocitySpan) last_.pop_front();
}

}  // namespace kestrel
