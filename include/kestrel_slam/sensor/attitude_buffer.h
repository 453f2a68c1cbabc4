// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <deque>
#include <optional>

namespace kestrel {

/// How the vehicle was oriented at one time.
struct Attitude {
  Eigen::Quaterniond stabilized_R_base = Eigen::Quaterniond::Identity();  ///< roll and pitch only
  double integrated_yaw = 0.0;  ///< integrated turn rate about the vertical, rad, not wrapped; only
                                ///< differences have a meaning
  /// Integrated horizontal acceleration, m/s, in the frame in which `integrated_yaw` counts: only
  /// differences have a meaning. Absent without an accelerometer.
  std::optional<Eigen::Vector2d> integrated_acceleration;
};

/// Why a buffer has no attitude for a time. kNotYet: it may still come.
enum class AttitudeError { kNone, kEmpty, kTooOld, kNotYet, kGap };

/// One lower-case phrase for each error, as used in statistics and diagnostics.
const char* toString(AttitudeError error);

struct AttitudeBufferConfig {
  double history_s = 10.0;  ///< how long attitudes are kept
  double max_gap_s = 0.25;  ///< longest time between two attitudes that is interpolated
};

/// Attitudes of the last seconds, to be interpolated at any time between them.
///
/// The orientation's own yaw is not used where a gyro is: a magnetometer makes it jump. Stamps may
/// come out of order; each is put into its place.
class AttitudeBuffer {
 public:
  explicit AttitudeBuffer(const AttitudeBufferConfig& config = AttitudeBufferConfig());

  /// `world_R_base`: unit quaternion, z of world up. `angular_velocity`: of the base, in its own
  /// frame, rad/s; without it the yaw follows the quaternion's yaw. False (and nothing is
  /// changed) where something is not finite, the stamp is already there, or older than the history.
  /// `specific_force`: of the accelerometer, in the base, m/s²; not used where it is no such thing.
  bool add(double stamp, const Eigen::Quaterniond& world_R_base,
           const std::optional<Eigen::Vector3d>& angular_velocity,
           const std::optional<Eigen::Vector3d>& specific_force = std::nullopt);

  /// The attitude at `time`; `attitude` is meaningful only where the result is kNone.
  AttitudeError lookup(double time, Attitude& attitude) const;

  /// Whether every time from `from` to `to` has an attitude; the first reason why not.
  AttitudeError covers(double from, double to) const;

  std::optional<double> latest() const;  ///< newest stamp
  std::size_t size() const { return entries_.size(); }
  void clear();

 private:
  struct Entry {
    double stamp;
    Eigen::Quaterniond stabilized_R_base;
    double yaw;                                   ///< of the quaternion, rad
    std::optional<double> yaw_rate;               ///< about the vertical, rad/s
    double integrated_yaw;                        ///< integrated
    std::optional<Eigen::Vector2d> acceleration;  ///< horizontal, in base_stabilized, m/s²
    Eigen::Vector2d integrated_acceleration;      ///< integrated
  };
  using Iterator = std::deque<Entry>::const_iterator;

  Iterator firstNotBefore(double time) const;
  static double turnBetween(const Entry& a, const Entry& b);
  static Eigen::Vector2d gainBetween(const Entry& a, const Entry& b);
  void integrateFrom(std::size_t index);

  AttitudeBufferConfig config_;
  std::deque<Entry> entries_;  ///< ascending stamps
};

}  // namespace kestrel
