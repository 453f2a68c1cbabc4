// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// The beams of one sweep without a return. Glass, mirrors and black surfaces give no return, so
/// such a beam does not show how far the space is free. The neighboring returns do: it is free at
/// most up to the line between them. Beams are added in the order of the sweep.
class UnansweredBeams {
 public:
  /// A return at `end`, in the plane of the rays, m.
  void addReturn(const Eigen::Vector2f& end);

  /// A beam without a return, from `origin`. Free space is cleared at most up to
  /// `origin + reach`, m.
  void addBeam(const Eigen::Vector2f& origin, const Eigen::Vector2f& reach);

  void appendTo(std::vector<PlanarRay>& rays) const;

 private:
  struct Beam {
    std::size_t next_return;  ///< index in `returns_`
    Eigen::Vector2f origin, reach;
  };

  float freeShare(const Beam& beam) const;

  std::vector<Eigen::Vector2f> returns_;
  std::vector<Beam> beams_;
};

}  // namespace kestrel
