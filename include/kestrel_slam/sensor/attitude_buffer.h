// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <deque>
#include <optional>

namespace kestrel {

/// Orientation of the vehicle at one time.
struct Attitude {
  /// Roll and pitch; the yaw is 0.
  Eigen::Quaterniond stabilized_R_base = Eigen::Quaterniond::Identity();
  double integrated_yaw = 0.0;  ///< rad, integrated yaw rate, not wrapped; only differences between
                                ///< two times are meaningful
  /// Integrated horizontal acceleration, m/s, in a frame that is rotated from base_stabilized by
  /// `integrated_yaw`. Only differences between two times are meaningful. Absent without an
  /// accelerometer.
  std::optional<Eigen::Vector2d> integrated_acceleration;
};

/// Why the buffer has no attitude for a time. kNotYet: the time is newer than all attitudes, one
/// may still arrive.
enum class AttitudeError { kNone, kEmpty, kTooOld, kNotYet, kGap };

/// A lower-case phrase for each error, for statistics and diagnostics.
const char* toString(AttitudeError error);

struct AttitudeBufferConfig {
  double history_s = 10.0;  ///< attitudes older than this, relative to the newest, are removed
  /// No interpolation between two attitudes that are farther apart than this.
  double max_gap_s = 0.25;
};

/// Attitudes of the last seconds, interpolated at any time between the oldest and the newest.
///
/// The yaw is integrated from the gyro where there is one. The yaw of the orientation is not used
/// then, because a magnetometer makes it jump. Stamps may arrive out of order; they are sorted.
class AttitudeBuffer {
 public:
  explicit AttitudeBuffer(const AttitudeBufferConfig& config = AttitudeBufferConfig());

  /// Adds an attitude.
  /// `stamp`: s. `world_R_base`: orientation, z of `world` points up. `angular_velocity`: of the
  /// base, in the base frame, rad/s; if absent, the yaw is taken from the orientation.
  /// `specific_force`: of the accelerometer, in the base frame, m/s²; ignored if its norm is
  /// implausible.
  /// Returns false and changes nothing if a value is not finite, if the stamp already exists, or if
  /// it is older than the history.
  bool add(double stamp, const Eigen::Quaterniond& world_R_base,
           const std::optional<Eigen::Vector3d>& angular_velocity,
           const std::optional<Eigen::Vector3d>& specific_force = std::nullopt);

  /// Interpolates the attitude at `time` (s). `attitude` is valid only if the result is kNone.
  AttitudeError lookup(double time, Attitude& attitude) const;

  /// kNone if every time from `from` to `to` (s) has an attitude, else the first error.
  AttitudeError covers(double from, double to) const;

  std::optional<double> latest() const;  ///< newest stamp, s
  std::size_t size() const { return entries_.size(); }
  void clear();

 private:
  struct Entry {
    double stamp;
    Eigen::Quaterniond stabilized_R_base;
    double yaw;                                   ///< of the quaternion, rad
    std::optional<double> yaw_rate;               ///< about the vertical, rad/s
    double integrated_yaw;                        ///< rad
    std::optional<Eigen::Vector2d> acceleration;  ///< horizontal, in base_stabilized, m/s²
    Eigen::Vector2d integrated_acceleration;      ///< m/s
  };
  using Iterator = std::deque<Entry>::const_iterator;

  Iterator firstNotBefore(double time) const;
  double yawChange(const Entry& a, const Entry& b) const;
  static Eigen::Vector2d velocityChange(const Entry& a, const Entry& b);
  void integrateFrom(std::size_t index);

  AttitudeBufferConfig config_;
  std::deque<Entry> entries_;  ///< ascending stamps
};

}  // namespace kestrel
