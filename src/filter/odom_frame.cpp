// SPDX-License-Identifier: BSD-3-Clause
#include "odom_frame.h"

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/sensor/attitude_buffer.h"

namespace kestrel {

Eigen::Quaterniond OdomFrame::mapROdom() const {
  return Eigen::Quaterniond(Eigen::AngleAxisd(yaw_, Eigen::Vector3d::UnitZ()));
}

void OdomFrame::advance(const FilterState& before, const FilterState& predicted,
                        const FilterState& now) {
  position_ += mapROdom().conjugate() * (predicted.position - before.position);
  correct(predicted, now);
}

void OdomFrame::correct(const FilterState& before, const FilterState& after) {
  yaw_ = normalizeAngle(yaw_ + yawOf(after.map_R_base) - yawOf(before.map_R_base));
}

Eigen::Isometry3d OdomFrame::odomTBase(const FilterState& state) const {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = (mapROdom().conjugate() * state.map_R_base).toRotationMatrix();
  result.translation() = position_;
  return result;
}

Eigen::Isometry3d OdomFrame::mapTOdom(const FilterState& state) const {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  result.linear() = mapROdom().toRotationMatrix();
  result.translation() = state.position - mapROdom() * position_;
  return result;
}

}  // namespace kestrel
