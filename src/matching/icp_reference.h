// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <mutex>

#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/nearest_points.h"

namespace kestrel {

/// The points of the map's surface around a place: where the hits of its occupied cells lie, and
/// which way their walls run.
std::vector<WallPoint> surfacePoints(const Submap& map, const Eigen::AlignedBox2f& area);

/// The hits of the last inserted scans, in map. A normal is that of the line through the hits of
/// the same sweep beside it.
std::vector<WallPoint> lastScanPoints(const Submap& map, std::size_t scans);

/// The points that scans are paired with, in a tree that is built again only where the map has
/// changed or the vehicle has left the part of it that the tree covers. What lies in an asked area
/// is the same as in a tree built for it alone: the class only remembers.
class IcpReference {
 public:
  /// Those of the map's surface, or of its last `last_scans` scans where that is not 0.
  explicit IcpReference(std::size_t last_scans) : last_scans_(last_scans) {}

  /// A tree with all points of `map` in `area`, and perhaps more around it.
  std::shared_ptr<const NearestPoints> around(const Submap& map,
                                              const Eigen::AlignedBox2f& area) const;

 private:
  std::size_t last_scans_;
  mutable std::mutex mutex_;
  mutable std::uint64_t revision_ = 0;  ///< of the map in the tree
  mutable Eigen::AlignedBox2f area_;
  mutable std::shared_ptr<const NearestPoints> points_;
};

}  // namespace kestrel
