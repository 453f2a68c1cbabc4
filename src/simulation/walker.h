// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/simulation/world.h"
#include "solids.h"

namespace kestrel {

/// The closed path of a walker, with precomputed lengths.
class WalkerPath {
 public:
  explicit WalkerPath(const Walker& walker);

  struct Step {
    Eigen::Vector2d position;
    Eigen::Vector2d direction;  ///< unit vector of the walking direction
    double traveled;            ///< m since the first corner; grows beyond one round
  };
  Step at(double time) const;
  /// The place after this distance, m.
  Step alongPath(double traveled) const;

  double length() const { return corner_at_.back(); }
  double speed() const { return walker_.speed_m_s; }
  double distanceTo(const Eigen::Vector2d& point) const { return walker_.distanceToPath(point); }

 private:
  Walker walker_;
  std::vector<double> corner_at_;  ///< distance along the polygon of each corner and the end, m
};

/// Updates `nearest` if the ray hits the legs or the trunk closer than that.
void intersectPerson(const WalkerPath::Step& step, const Ray& ray, RayHit& nearest);

}  // namespace kestrel
