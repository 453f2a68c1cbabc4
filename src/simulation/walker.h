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

  /// Updates `nearest` if the ray at `time` hits the legs or the trunk closer than that.
  void intersect(const Ray& ray, double time, RayHit& nearest) const;

 private:
  Walker walker_;
  std::vector<double> corner_at_;  ///< distance along the polygon of each corner and the end, m
};

}  // namespace kestrel
