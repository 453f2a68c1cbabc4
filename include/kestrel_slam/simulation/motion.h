// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace kestrel {

/// Where a simulated vehicle truly is and how it moves. z of `world` points up.
struct TrueState {
  Eigen::Isometry3d world_T_base = Eigen::Isometry3d::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          ///< in world, m/s
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();      ///< in world, without gravity, m/s²
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< of the base, in base, rad/s
};

/// A known motion; smooth: each member of the state is the derivative that its name says.
class Motion {
 public:
  virtual ~Motion() = default;
  virtual double duration() const = 0;  ///< s
  /// The state at `time` (s) after the start; before and after the motion the vehicle rests.
  virtual TrueState at(double time) const = 0;
};

}  // namespace kestrel
