// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "filter_state.h"

namespace kestrel {

/// Keeps odom_T_base continuous (REP-105): it follows the propagated motion. Corrections of
/// position and yaw in the map move the frame odom instead.
class OdomFrame {
 public:
  /// The estimate was propagated from `before` to `predicted`, and then corrected to `now`.
  void advance(const FilterState& before, const FilterState& predicted, const FilterState& now);
  /// The estimate at one time was corrected.
  void correct(const FilterState& before, const FilterState& after);

  Eigen::Isometry3d odomTBase(const FilterState& state) const;
  Eigen::Isometry3d mapTOdom(const FilterState& state) const;

 private:
  Eigen::Quaterniond mapROdom() const;

  Eigen::Vector3d position_ = Eigen::Vector3d::Zero();  ///< of the base in the odom frame, m
  double yaw_ = 0.0;                                    ///< of the odom frame in the map frame, rad
};

}  // namespace kestrel
