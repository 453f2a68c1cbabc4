// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <optional>

#include "kestrel_slam/filter/filter_types.h"
#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/sensor/attitude_buffer.h"

namespace kestrel {

/// What the scan projector needs to know of one state of the pose filter.
struct FilteredMotion {
  double stamp = 0.0;                                               ///< s
  Eigen::Quaterniond odom_R_base = Eigen::Quaterniond::Identity();  ///< orientation in odom
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();       ///< in base, rad/s
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();         ///< in base, m/s²
  Pose2 odom_T_base;                                                ///< seen from above
  std::optional<double> height_m;  ///< of the base over what is below, while it is known
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< in base_stabilized, m/s
  bool gives_attitude = false;    ///< roll and pitch are known well enough for the projection
  bool gives_prediction = false;  ///< the motion is known well enough for the mapper
};

/// The part of a filter state that the projector uses.
FilteredMotion motionOf(const FilterOutput& output);

/// The filter states of the last seconds: attitudes for the projection, motion for the mapper.
class FilteredMotionBuffer {
 public:
  explicit FilteredMotionBuffer(const AttitudeBufferConfig& config);

  /// False where the attitude is not used: it is not known well enough, a number is not
  /// finite, or the stamp is there already. Stamps far in the past clear the buffer (a clock that
  /// was set back).
  bool add(const FilteredMotion& motion);

  const AttitudeBuffer& attitude() const { return attitude_; }

  /// Whether the filter was running shortly before `time` (s).
  bool runs(double time) const;

  /// odom_T_base at `time` (s), interpolated; nothing where the motion is not known well enough.
  std::optional<Pose2> odomPose(double time) const;

 private:
  struct State {
    double stamp;
    Pose2 odom_T_base;
    bool gives_prediction;
  };

  double history_s_;
  AttitudeBuffer attitude_;
  std::deque<State> states_;  ///< ascending stamps
};

}  // namespace kestrel
