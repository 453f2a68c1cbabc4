// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "kestrel_slam/geometry/nearest_points.h"
#include "kestrel_slam/map/submap.h"

namespace kestrel {

/// A point of a wall.
struct WallPoint {
  Eigen::Vector2f position;  ///< m
  Eigen::Vector2f normal;    ///< unit normal of the wall; zero if unknown
};

/// Points of walls, and which of them is near to a place.
class WallPoints {
 public:
  explicit WallPoints(std::vector<WallPoint> points);

  /// The point nearest to `place` (m), or nullptr if none is closer than `reach_m`.
  const WallPoint* nearest(const Eigen::Vector2f& place, float reach_m) const;

 private:
  std::vector<WallPoint> points_;
  NearestPoints<2> tree_;
};

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
  std::shared_ptr<const WallPoints> around(const Submap& map,
                                           const Eigen::AlignedBox2f& area) const;

 private:
  std::size_t last_scans_;
  mutable std::mutex mutex_;
  mutable std::uint64_t revision_ = 0;  ///< revision of the map in the tree
  mutable Eigen::AlignedBox2f area_;
  mutable std::shared_ptr<const WallPoints> points_;
};

}  // namespace kestrel
