// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// The map of a mapper, built again from its scans and results. Experiments use it because they
/// need the map as it was before a scan was inserted. Everything that decides on the insertion is
/// in here, so that all experiments have the map of the mapper.
class ReplayedMap {
 public:
  explicit ReplayedMap(const MapperConfig& mapper);
  /// `options`: what the experiment needs of the map in addition.
  ReplayedMap(const MapperConfig& mapper, const SubmapOptions& options);
  /// The same with another cell size (m).
  ReplayedMap(const MapperConfig& mapper, double resolution_m);

  /// Adds the next scan of the mapper and its result.
  void add(const PlanarScan& scan, const MapperResult& result);

  const Submap& map() const { return map_; }
  /// Moves the map out. Afterwards the object must not be used.
  Submap take() { return std::move(map_); }

 private:
  MapperConfig mapper_;
  Submap map_;
};

}  // namespace kestrel
