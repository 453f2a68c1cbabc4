// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <optional>

#include "kestrel_slam/filter/filter_types.h"
#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/sensor/attitude_buffer.h"

namespace kestrel {

/// The part of one pose filter state that the scan projector needs.
struct FilteredMotion {
  double stamp = 0.0;                                               ///< s
  Eigen::Quaterniond odom_R_base = Eigen::Quaterniond::Identity();  ///< orientation in odom
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();       ///< in base, rad/s
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();         ///< in base, m/s²
  Pose2 odom_T_base;                                                ///< horizontal pose
  std::optional<double> height_m;  ///< base above the surface below; absent: unknown
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< in base_stabilized, m/s
  bool gives_attitude = false;    ///< roll and pitch are known well enough for the projection
  bool gives_prediction = false;  ///< the motion is known well enough for the mapper
};

/// Extracts from a filter output what the projector uses.
FilteredMotion motionOf(const FilterOutput& output);

/// Stores the filter states of the last seconds. They give the attitude for the projection and the
/// motion prediction for the mapper.
class FilteredMotionBuffer {
 public:
  explicit FilteredMotionBuffer(const AttitudeBufferConfig& config);

  /// Returns false if the attitude is not used: it is not known well enough, a value is not
  /// finite, or its stamp is already stored. The states of a filter have ascending stamps: an older
  /// stamp means that filter or recording started again, and clears the buffer.
  bool add(const FilteredMotion& motion);

  const AttitudeBuffer& attitude() const { return attitude_; }

  /// True if the filter was running shortly before `time` (s). States far in the future do not
  /// count: they come from a wrong stamp.
  bool runs(double time) const;

  /// Interpolated odom_T_base at `time` (s). Empty if the motion is not known well enough.
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
