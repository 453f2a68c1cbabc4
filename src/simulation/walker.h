// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/simulation/world.h"
#include "solids.h"

namespace kestrel {

/// The way of a walker, measured once.
class WalkerPath {
 public:
  explicit WalkerPath(const Walker& walker);

  struct Step {
    Eigen::Vector2d position;
    Eigen::Vector2d heading;  ///< unit vector
    double traveled;          ///< m since the first corner, more than one round counts on
  };
  Step at(double time) const;

  /// Updates `nearest` where the ray meets the legs or the trunk before, at `time`.
  void meet(const Ray& ray, double time, RayHit& nearest) const;

 private:
  Walker walker_;
  std::vector<double> corner_at_;  ///< m along the polygon, of each corner and the way's end
};

}  // namespace kestrel
