// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/attitude_buffer.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"

namespace kestrel {
namespace {

/// Smallest cosine of the pitch for the yaw rate. Below it the nose points straight up or down, and
/// the yaw is undefined.
constexpr double kMinPitchCosine = 1e-3;

/// Yaw rate of the base for ZYX Euler angles [Kohlbrecher 2011, eq. 1], rad/s.
double yawRate(const Eigen::Quaterniond& stabilized_R_base, const Eigen::Vector3d& rate) {
  const Eigen::Matrix3d r = stabilized_R_base.toRotationMatrix();
  const double cosine = std::max(std::hypot(r(2, 1), r(2, 2)), kMinPitchCosine);
  return (r(2, 1) * rate.y() + r(2, 2) * rate.z()) / (cosine * cosine);
}

/// Whether the norm is one that an accelerometer measures in flight, m/s². False for NaN.
bool isPlausible(const Eigen::Vector3d& specific_force) {
  constexpr double kSmallest = 3.0, kLargest = 30.0;
  const double size = specific_force.norm();
  return size > kSmallest && size < kLargest;
}

}  // namespace

const char* toString(AttitudeError error) {
  switch (error) {
    case AttitudeError::kNone:
      return "none";
    case AttitudeError::kEmpty:
      return "no attitude yet";
    case AttitudeError::kTooOld:
      return "older than the attitudes";
    case AttitudeError::kNotYet:
      return "newer than the attitudes";
    case AttitudeError::kGap:
      return "gap between the attitudes";
  }
  return "unknown";
}

AttitudeBuffer::AttitudeBuffer(const AttitudeBufferConfig& config) : config_(config) {}

AttitudeBuffer::Iterator AttitudeBuffer::firstNotBefore(double time) const {
  return std::lower_bound(entries_.begin(), entries_.end(), time,
                          [](const Entry& entry, double t) { return entry.stamp < t; });
}

bool AttitudeBuffer::add(double stamp, const Eigen::Quaterniond& world_R_base,
                         const std::optional<Eigen::Vector3d>& angular_velocity,
                         const std::optional<Eigen::Vector3d>& specific_force) {
  const double norm = world_R_base.norm();
  const bool finite = std::isfinite(stamp) && std::isfinite(norm) && norm > 0.0 &&
                      (!angular_velocity || angular_velocity->allFinite());
  if (!finite) return false;
  if (!entries_.empty() && stamp < entries_.back().stamp - config_.history_s) return false;
  const Iterator place = firstNotBefore(stamp);
  if (place != entries_.end() && place->stamp == stamp) return false;

  const Eigen::Quaterniond orientation = world_R_base.normalized();
  Entry entry{stamp, withoutYaw(orientation), yawOf(orientation), {}, 0.0, {}, {0.0, 0.0}};
  if (angular_velocity) entry.yaw_rate = yawRate(entry.stabilized_R_base, *angular_velocity);
  if (specific_force && isPlausible(*specific_force)) {
    entry.acceleration = (entry.stabilized_R_base * *specific_force).head<2>();
  }
  const auto index = static_cast<std::size_t>(place - entries_.begin());
  entries_.insert(place, entry);
  integrateFrom(index);
  while (entries_.front().stamp < entries_.back().stamp - config_.history_s) entries_.pop_front();
  return true;
}

void AttitudeBuffer::integrateFrom(std::size_t index) {
  if (index == 0 && entries_.size() > 1) {
    // Values that were returned before must not change. Therefore a new first entry is computed
    // backwards from the second.
    entries_[0].integrated_yaw = entries_[1].integrated_yaw - yawChange(entries_[0], entries_[1]);
    entries_[0].integrated_acceleration =
        entries_[1].integrated_acceleration - velocityChange(entries_[0], entries_[1]);
    return;
  }
  for (std::size_t i = std::max<std::size_t>(index, 1); i < entries_.size(); ++i) {
    entries_[i].integrated_yaw =
        entries_[i - 1].integrated_yaw + yawChange(entries_[i - 1], entries_[i]);
    entries_[i].integrated_acceleration =
        entries_[i - 1].integrated_acceleration + velocityChange(entries_[i - 1], entries_[i]);
  }
}

/// What the vehicle did in a gap of the IMU is unknown. The change is then so large that nobody
/// takes the difference across the gap for a turn.
double AttitudeBuffer::yawChange(const Entry& a, const Entry& b) const {
  constexpr double kUnknownTurn = 1e4;  // rad
  if (b.stamp - a.stamp > config_.max_gap_s) return kUnknownTurn;
  if (!a.yaw_rate || !b.yaw_rate) return normalizeAngle(b.yaw - a.yaw);
  return 0.5 * (*a.yaw_rate + *b.yaw_rate) * (b.stamp - a.stamp);
}

Eigen::Vector2d AttitudeBuffer::velocityChange(const Entry& a, const Entry& b) {
  if (!a.acceleration || !b.acceleration) return Eigen::Vector2d::Zero();
  const Eigen::Vector2d before = Eigen::Rotation2Dd(a.integrated_yaw) * *a.acceleration;
  const Eigen::Vector2d after = Eigen::Rotation2Dd(b.integrated_yaw) * *b.acceleration;
  return 0.5 * (before + after) * (b.stamp - a.stamp);
}

AttitudeError AttitudeBuffer::lookup(double time, Attitude& attitude) const {
  if (entries_.empty()) return AttitudeError::kEmpty;
  if (!(time >= entries_.front().stamp)) return AttitudeError::kTooOld;
  if (time > entries_.back().stamp) return AttitudeError::kNotYet;
  const Iterator after = firstNotBefore(time);
  if (after->stamp == time) {
    attitude = {after->stabilized_R_base, after->integrated_yaw, std::nullopt};
    if (after->acceleration) attitude.integrated_acceleration = after->integrated_acceleration;
    return AttitudeError::kNone;
  }
  const Entry& b = *after;
  const Entry& a = *(after - 1);
  const double span = b.stamp - a.stamp, elapsed = time - a.stamp;
  if (span > config_.max_gap_s) return AttitudeError::kGap;
  attitude.stabilized_R_base = a.stabilized_R_base.slerp(elapsed / span, b.stabilized_R_base);
  attitude.integrated_acceleration.reset();
  if (a.acceleration && b.acceleration) {
    attitude.integrated_acceleration =
        a.integrated_acceleration +
        elapsed / span * (b.integrated_acceleration - a.integrated_acceleration);
  }
  if (a.yaw_rate && b.yaw_rate) {  // linear rate between two readings
    const double change = (*b.yaw_rate - *a.yaw_rate) / span;
    attitude.integrated_yaw = a.integrated_yaw + elapsed * (*a.yaw_rate + 0.5 * change * elapsed);
  } else {
    attitude.integrated_yaw =
        a.integrated_yaw + elapsed / span * (b.integrated_yaw - a.integrated_yaw);
  }
  return AttitudeError::kNone;
}

AttitudeError AttitudeBuffer::covers(double from, double to) const {
  Attitude unused;
  for (const double end : {from, to}) {
    const AttitudeError error = lookup(end, unused);
    if (error != AttitudeError::kNone) return error;
  }
  for (Iterator next = firstNotBefore(from); next != entries_.end() && next->stamp < to; ++next) {
    const Iterator after = next + 1;
    if (after != entries_.end() && after->stamp - next->stamp > config_.max_gap_s) {
      return AttitudeError::kGap;
    }
  }
  return AttitudeError::kNone;
}

std::optional<double> AttitudeBuffer::latest() const {
  if (entries_.empty()) return std::nullopt;
  return entries_.back().stamp;
}

void AttitudeBuffer::clear() { entries_.clear(); }

}  // namespace kestrel
