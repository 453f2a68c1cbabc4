// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/geometry/pose3.h"

#include <cmath>

namespace kestrel {

double yawOf(const Eigen::Quaterniond& world_R_base) {
  const Eigen::Vector3d nose = world_R_base * Eigen::Vector3d::UnitX();
  return std::atan2(nose.y(), nose.x());
}

double tiltOf(const Eigen::Quaterniond& world_R_base) {
  const Eigen::Vector3d up = world_R_base * Eigen::Vector3d::UnitZ();
  return std::atan2(std::hypot(up.x(), up.y()), up.z());
}

Eigen::Quaterniond withoutYaw(const Eigen::Quaterniond& world_R_base) {
  const Eigen::Quaterniond undo(Eigen::AngleAxisd(-yawOf(world_R_base), Eigen::Vector3d::UnitZ()));
  return (undo * world_R_base).normalized();
}

Pose2 toPose2(const Eigen::Isometry3d& transform) {
  const Eigen::Matrix3d rotation = transform.linear();
  return {transform.translation().x(), transform.translation().y(),
          std::atan2(rotation(1, 0), rotation(0, 0))};
}

}  // namespace kestrel
