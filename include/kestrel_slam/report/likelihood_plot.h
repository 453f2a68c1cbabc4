// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/matching/likelihood_surface.h"

namespace kestrel {

/// Watches a mapper, and looks at one of its scans: how likely every pose around the found one is,
/// in the map as it was then.
class LikelihoodWatch {
 public:
  /// `scan`: which one, counted from 0. Throws std::invalid_argument for the first, which defines
  /// the map.
  LikelihoodWatch(const MapperConfig& mapper, std::size_t scan);

  /// What the watched mapper made of its next scan.
  void add(const PlanarScan& scan, const MapperResult& result);

  /// Writes a PNG: the best likelihood over all yaws around the scan's pose, the pose and the 3
  /// sigma ellipse that it claims. Throws std::runtime_error where the scan did not come.
  void write(const std::string& path) const;

  const LikelihoodSurface& surface() const { return surface_; }

 private:
  MapperConfig mapper_;
  std::size_t wanted_;
  std::size_t scans_ = 0;
  Submap map_;
  LikelihoodSurface surface_;
  MapperResult result_;
};

}  // namespace kestrel
