// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "kestrel_slam/simulation/world.h"
#include "solids.h"
#include "walker.h"

namespace kestrel {

/// The people of a world. Who can meet nobody walks on his path exactly. The others keep
/// kBodyDistance apart: they slow down, wait and step aside, but not far from their paths and not
/// into solids. Their steps are computed when they are first asked for; they do not depend on what
/// was asked before.
class Crowd {
 public:
  explicit Crowd(const World::Parts& parts);
  ~Crowd();
  Crowd(Crowd&&) noexcept;
  Crowd& operator=(Crowd&&) noexcept;

  /// Before time 0 and after one hour, those who can meet somebody stand.
  WalkerPath::Step at(std::size_t person, double time) const;

  /// Updates `nearest` if the ray hits a person closer than that.
  void intersect(const Ray& ray, RayHit& nearest) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
