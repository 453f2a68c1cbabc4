// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "filter_state.h"

namespace kestrel {

/// Keeps the pose in odom continuous: it moves as the estimate is propagated, and what corrects the
/// place or the yaw in map moves the frame odom instead (REP-105).
class OdomFrame {
 public:
  /// The estimate moved from `before` to `predicted` by propagation alone, and was then corrected
  /// to `now`.
  void advance(const FilterState& before, const FilterState& predicted, const FilterState& now);
  /// The estimate of one time was corrected.
  void correct(const FilterState& before, const FilterState& after);

  Eigen::Isometry3d odomTBase(const FilterState& state) const;
  Eigen::Isometry3d mapTOdom(const FilterState& state) const;

 private:
  Eigen::Quaterniond mapROdom() const;

  Eigen::Vector3d position_ = Eigen::Vector3d::Zero();  ///< of the base in odom, m
  double yaw_ = 0.0;                                    ///< of odom in map, rad
};

}  // namespace kestrel
