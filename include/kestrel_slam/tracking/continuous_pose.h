// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// Makes a pose without jumps (odom_T_base) from the poses of the mapper. Tracks live in this
/// frame: a jump of the map must not move them, and must not make walls move.
///
/// It adds up the motion from scan to scan. Where the mapper may have jumped, because it searched
/// its place again or because it does not know it, the motion comes from the odometry, or without
/// odometry from the last motion.
class ContinuousPose {
 public:
  /// `may_jump`: do not trust the step from the last pose to this one. `time` in s.
  Pose2 add(double time, const Pose2& map_T_base, bool may_jump,
            const std::optional<Pose2>& odom_T_base = std::nullopt);

  /// The pose at `time` (s) if the motion goes on; identity before the first pose.
  Pose2 predict(double time) const;

 private:
  struct Last {
    double time;
    Pose2 map_T_base;
    std::optional<Pose2> odom_T_base;
  };
  std::optional<Last> last_;
  Pose2 pose_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  ///< tangent per second
};

}  // namespace kestrel
