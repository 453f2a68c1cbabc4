// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/time_base.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kestrel {

double MonotoneTime::repair(double stamp) {
  if (!started_) {
    started_ = true;
    last_stamped_time_ = last_time_ = std::isfinite(stamp) ? stamp + offset_ : 0.0;
    return last_time_;
  }
  if (!std::isfinite(stamp)) {
    ++repaired_;
    return advance(typical_step_);
  }
  if (!continues(stamp + offset_)) {
    if (!pending_offset_ || !continues(stamp + *pending_offset_)) return jump(stamp);
    offset_ = *pending_offset_;
  }
  pending_offset_.reset();
  const double step = stamp + offset_ - last_stamped_time_;
  last_stamped_time_ += step;
  learnStep(step);
  return follow(stamp + offset_, step <= 0.0);
}

bool MonotoneTime::continues(double time) const {
  // Smaller steps back are late stamps (intel.clf: up to 0.9 s). Smaller steps ahead follow a
  // pause.
  constexpr double kMaxLate = 5.0, kMaxGap = 60.0;
  const double step = time - last_time_;
  return step > -kMaxLate && step <= kMaxGap;
}

double MonotoneTime::follow(double time, bool late) {
  // Stamps that go back show when a scan was logged, not when it was taken. The scans of intel.clf
  // are evenly spaced, but their stamps are 0.001 to 1.4 s apart. Therefore the times are evenly
  // spaced, and are only slowly corrected towards the stamps.
  constexpr int kDistrusted = 500;  // number of scans after a late stamp
  constexpr double kGain = 0.02;
  // Smallest step, relative to the typical one, while the times are ahead of the stamps.
  constexpr double kMinShare = 0.2;
  constexpr double kMaxPause = 5.0;  // s; a larger step is a pause of the laser

  if (late) distrusted_ = kDistrusted;
  if (distrusted_ > 0) --distrusted_;
  const double even = last_time_ + typical_step_;
  const bool trusted = distrusted_ == 0 && time > last_time_;
  if (trusted || time > even + kMaxPause) return last_time_ = time;
  ++repaired_;
  return advance(std::max(typical_step_ + kGain * (time - even), kMinShare * typical_step_));
}

double MonotoneTime::jump(double stamp) {
  ++repaired_;
  const double time = advance(typical_step_);
  pending_offset_ = time - stamp;
  return time;
}

double MonotoneTime::advance(double step) {
  // At a stamp of 1e300 a step of 0.1 s is lost in rounding. Then the next larger number is used.
  const double next = std::nextafter(last_time_, std::numeric_limits<double>::infinity());
  return last_time_ = std::max(last_time_ + step, next);
}

void MonotoneTime::learnStep(double step) {
  constexpr double kMinStep = 1e-3, kMaxStep = 2.0;  // s; a pause is not typical
  constexpr double kLearningRate = 0.02;
  const double learned =
      typical_step_ + kLearningRate * (std::clamp(step, -kMaxStep, kMaxStep) - typical_step_);
  typical_step_ = std::max(learned, kMinStep);
}

double TimeBase::repair(const std::string& source, double stamp) {
  MonotoneTime& monotone = timeOf(source);
  const double time = monotone.repair(stamp);
  offset_ = monotone.offset();
  return time;
}

/// A new source has the clock of the others, also after that was set. The number of sources is
/// limited: broken messages may have any frame.
MonotoneTime& TimeBase::timeOf(const std::string& source) {
  constexpr std::size_t kMostSources = 32;
  const auto known = sources_.find(source);
  if (known != sources_.end()) return known->second;
  const std::string& name = sources_.size() < kMostSources ? source : sources_.begin()->first;
  return sources_.try_emplace(name, offset_).first->second;
}

std::size_t TimeBase::repaired() const {
  std::size_t sum = 0;
  for (const auto& entry : sources_) sum += entry.second.repaired();
  return sum;
}

}  // namespace kestrel
