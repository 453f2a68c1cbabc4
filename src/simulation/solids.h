// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "kestrel_slam/simulation/world.h"

namespace kestrel {

/// A beam in world.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  ///< unit vector
  double time = 0.0;          ///< s
};

/// A box, prepared for ray casting. If the ray starts inside, the hit has distance 0.
class BoxSolid {
 public:
  explicit BoxSolid(const Box& box);

  /// Updates `nearest` if the ray hits the box closer than that.
  void intersect(const Ray& ray, RayHit& nearest) const;
  /// True if the outline, seen from above, overlaps the square cell around `center`.
  bool overlapsCell(const Eigen::Vector2d& center, double half_cell) const;
  /// Half the size of its outline along the axes of the world.
  Eigen::Vector2d halfExtent() const;
  Eigen::Vector2d center() const { return center_.head<2>(); }

 private:
  Eigen::Vector3d center_, half_;
  double cos_, sin_;
  Material material_;
  double from_s_, until_s_;  ///< time in which it exists
};

/// A vertical cylinder; methods as in BoxSolid.
class CylinderSolid {
 public:
  explicit CylinderSolid(const Cylinder& cylinder) : cylinder_(cylinder) {}

  void intersect(const Ray& ray, RayHit& nearest) const;
  bool overlapsCell(const Eigen::Vector2d& center, double half_cell) const;
  Eigen::Vector2d halfExtent() const { return Eigen::Vector2d::Constant(cylinder_.radius); }
  const Eigen::Vector2d& center() const { return cylinder_.center; }

 private:
  Cylinder cylinder_;
};

/// Updates `nearest` if the ray hits the horizontal plane at height `z` closer than that.
void intersectPlane(double z, const Ray& ray, RayHit& nearest);

}  // namespace kestrel
