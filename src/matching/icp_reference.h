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

/// The means of the surfels in an area of the map, and the normals of their walls.
std::vector<WallPoint> surfacePoints(const Submap& map, const Eigen::AlignedBox2f& area);

/// The hits of the latest inserted scans, in the map frame. The normal is that of the line through
/// the neighboring hits of the same sweep.
std::vector<WallPoint> lastScanPoints(const Submap& map, std::size_t scans);

/// The reference points for pairing, in a tree. The tree is only rebuilt when the map has changed
/// or the requested area is not covered. Results for the requested area do not depend on this
/// cache.
class IcpReference {
 public:
  /// Uses the surface of the map if `last_scans` is 0, else the hits of the last `last_scans`
  /// scans.
  explicit IcpReference(std::size_t last_scans) : last_scans_(last_scans) {}

  /// A tree with at least all points of `map` in `area`.
  std::shared_ptr<const NearestPoints> around(const Submap& map,
                                              const Eigen::AlignedBox2f& area) const;

 private:
  std::size_t last_scans_;
  mutable std::mutex mutex_;
  mutable std::uint64_t revision_ = 0;  ///< revision of the map in the tree
  mutable Eigen::AlignedBox2f area_;
  mutable std::shared_ptr<const NearestPoints> points_;
};

}  // namespace kestrel
