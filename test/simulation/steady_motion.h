// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <utility>
#include <vector>

#include "kestrel_slam/simulation/motion.h"
#include "kestrel_slam/simulation/world.h"

namespace kestrel {

/// Starts at `start`, moves and yaws at constant rates, with constant roll and pitch.
class SteadyMotion : public Motion {
 public:
  Eigen::Isometry3d start = Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.0, 1.0));
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  double yaw_rate = 0.0;

  double duration() const override { return std::numeric_limits<double>::infinity(); }
  TrueState at(double time) const override {
    TrueState state;
    state.world_T_base.linear() =
        Eigen::AngleAxisd(yaw_rate * time, Eigen::Vector3d::UnitZ()) * start.linear();
    state.world_T_base.translation() = start.translation() + velocity * time;
    return state;
  }
};

inline const Eigen::Isometry3d kNoOffset = Eigen::Isometry3d::Identity();

inline World worldOf(std::vector<Box> boxes) {
  World::Parts parts;
  parts.boxes = std::move(boxes);
  return World(std::move(parts));
}

/// One long wall with its face at x = `distance`.
inline World wallAt(double distance, Material material = Material::kMatt) {
  return worldOf({{{distance + 0.5, 0, 1.5}, {1.0, 500.0, 3.0}, 0.0, material}});
}

}  // namespace kestrel
