// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace kestrel {

/// True pose, velocity and acceleration of a simulated vehicle. The z axis of `world` points up.
struct TrueState {
  Eigen::Isometry3d world_T_base = Eigen::Isometry3d::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          ///< in world, m/s
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();      ///< in world, without gravity, m/s²
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< in the base frame, rad/s
};

/// The known motion of a vehicle. Implementations must be consistent: `velocity` is the exact
/// derivative of the position, and so on.
class Motion {
 public:
  virtual ~Motion() = default;
  virtual double duration() const = 0;  ///< s
  /// The state at `time` (s since the start). Before and after the motion the vehicle is at rest.
  virtual TrueState at(double time) const = 0;
};

}  // namespace kestrel
