// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// The rotation without yaw, `stabilized_R_base` (REP-105), see [MAV SLAM 2013, eq. 1].
Eigen::Quaterniond withoutYaw(const Eigen::Quaterniond& world_R_base);

/// Yaw: the angle of the x axis of the base, seen from above, rad.
double yawOf(const Eigen::Quaterniond& world_R_base);

/// Angle between the base's z axis and the vertical, rad.
double tiltOf(const Eigen::Quaterniond& world_R_base);

/// Position and yaw seen from above.
Pose2 toPose2(const Eigen::Isometry3d& transform);

}  // namespace kestrel
