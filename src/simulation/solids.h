// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "kestrel_slam/simulation/world.h"

namespace kestrel {

struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  ///< of unit length
  double time = 0.0;          ///< s
};

/// A box that is ready to be met by rays. From inside of a solid thing everything is at distance 0.
class BoxSolid {
 public:
  explicit BoxSolid(const Box& box);

  /// Updates `nearest` where the ray meets the box before.
  void meet(const Ray& ray, RayHit& nearest) const;
  /// Does its outline, seen from above, overlap the square cell around `center`?
  bool overlapsCell(const Eigen::Vector2d& center, double half_cell) const;
  /// Half the size of its outline along the axes of the world.
  Eigen::Vector2d halfExtent() const;
  Eigen::Vector2d center() const { return center_.head<2>(); }

 private:
  Eigen::Vector3d center_, half_;
  double cos_, sin_;
  Material material_;
  double from_s_, until_s_;  ///< when it is there
};

/// The same for a vertical cylinder.
class CylinderSolid {
 public:
  explicit CylinderSolid(const Cylinder& cylinder) : cylinder_(cylinder) {}

  void meet(const Ray& ray, RayHit& nearest) const;
  bool overlapsCell(const Eigen::Vector2d& center, double half_cell) const;
  Eigen::Vector2d halfExtent() const { return Eigen::Vector2d::Constant(cylinder_.radius); }
  const Eigen::Vector2d& center() const { return cylinder_.center; }

 private:
  Cylinder cylinder_;
};

/// Updates `nearest` where the ray meets the horizontal plane at height `z` before.
void meetPlane(double z, const Ray& ray, RayHit& nearest);

}  // namespace kestrel
