// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/matching/likelihood_surface.h"
#include "kestrel_slam/offline/replayed_map.h"

namespace kestrel {

/// Computes, for one scan of a mapper, the likelihood of all poses around the matched pose, in the
/// map at that time.
class LikelihoodRecorder {
 public:
  /// `scan`: number of the scan, beginning with 0. Throws std::invalid_argument for scan 0, because
  /// it defines the map.
  LikelihoodRecorder(const MapperConfig& mapper, std::size_t scan);

  /// Adds the next scan of the mapper and its result.
  void add(const PlanarScan& scan, const MapperResult& result);

  /// Writes a PNG with the likelihood around the pose of the scan (the maximum over yaw), the pose
  /// and its 3 sigma ellipse. Throws std::runtime_error if the run ended before this scan.
  void write(const std::string& path) const;

  const LikelihoodSurface& surface() const { return surface_; }
  const Submap& map() const { return map_.map(); }

 private:
  MapperConfig mapper_;
  std::size_t wanted_;
  std::size_t scans_ = 0;
  ReplayedMap map_;
  LikelihoodSurface surface_;
  MapperResult result_;
};

}  // namespace kestrel
