// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/continued_motion.h"

#include <algorithm>
#include <cmath>

namespace kestrel {
namespace {

/// Scans are missing if an interval is this many times the typical one.
constexpr double kLongInterval = 5.0;
constexpr double kIntervalGain = 0.1;
/// Maximum motion in a period of the laser, m. After a larger one (the vehicle was carried, or its
/// pose jumped), and after a gap, the motion is not continued.
constexpr double kMaxStepM = 1.0;
/// The same, as a speed, where scans are rare and nothing measures the motion, m/s.
constexpr double kFastest = 3.0;
/// Weight of the errors before the last one.
constexpr double kKeptError = 0.8;

double difference(const Pose2& a, const Pose2& b) {
  const Pose2 between = a.between(b);
  return between.distance() + std::abs(between.yaw);
}

}  // namespace

double ContinuedMotion::periodsIn(double seconds) const {
  return typical_s_ > 0.0 ? std::round(seconds / typical_s_) : 1.0;
}

Pose2 ContinuedMotion::inProportion(double seconds) const {
  const double periods = std::min(periodsIn(seconds), kLongInterval);
  if (periods_ < 1.0 || periods < 1.0 || periods == periods_) return step_;
  return interpolate(Pose2(), step_, periods / periods_);
}

Pose2 ContinuedMotion::predict(double seconds) const {
  return repetition_error_ < proportion_error_ ? step_ : inProportion(seconds);
}

void ContinuedMotion::add(const Pose2& step, double seconds, bool is_measured) {
  const double proportion = difference(inProportion(seconds), step);
  const double repetition = difference(step_, step);
  if (proportion != repetition) {
    proportion_error_ = kKeptError * proportion_error_ + proportion;
    repetition_error_ = kKeptError * repetition_error_ + repetition;
  }
  periods_ = periodsIn(seconds);
  double farthest = kMaxStepM * std::max(1.0, periods_);
  if (!is_measured) farthest = std::max(farthest, kFastest * seconds);
  const bool usual = !isGap(seconds) && step.distance() <= farthest;
  step_ = usual ? step : Pose2();
}

void ContinuedMotion::addInterval(double seconds) {
  if (!(seconds > 0.0)) return;
  if (typical_s_ == 0.0) return learnInterval(seconds);
  // Beside the second interval the first one may be seen to be a gap.
  if (is_first_ && typical_s_ > kLongInterval * seconds) typical_s_ = seconds;
  const double usual_s = std::min(seconds, kLongInterval * typical_s_);
  typical_s_ += kIntervalGain * (usual_s - typical_s_);
  is_first_ = false;
}

void ContinuedMotion::learnInterval(double seconds) {
  if (typical_s_ == 0.0 && seconds > 0.0) typical_s_ = seconds;
}

void ContinuedMotion::takeInterval(const ContinuedMotion& other) {
  if (other.typical_s_ == 0.0) return;
  typical_s_ = other.typical_s_;
  is_first_ = other.is_first_;
}

bool ContinuedMotion::isGap(double seconds) const {
  return typical_s_ > 0.0 && seconds > kLongInterval * typical_s_;
}

}  // namespace kestrel
