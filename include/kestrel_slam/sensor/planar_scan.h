// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// Points in a common frame, m.
using Points = std::vector<Eigen::Vector2f>;

/// One beam in the gravity-aligned frame of the vehicle (x forward, y left, m), at the scan's
/// reference time.
struct PlanarRay {
  Eigen::Vector2f origin;  ///< position of the laser when it measured this beam
  Eigen::Vector2f end;  ///< the return; without a return, the end of the free space along the beam
  bool hit;             ///< true: return at `end`; false: the beam only clears free space
  /// For a hit: it is already in the map. It is not inserted again, but its cell is not cleared.
  bool known = false;
  /// The beam had no return. The space up to `end` is free only as far as the map has no wall:
  /// glass gives no return.
  bool no_return = false;
  /// The same beam up to the range limit: the space is presumably free up to `end`. The match uses
  /// this, but the map does not show it.
  bool presumed = false;
};

/// Height of a planar scan over the floor. The laser tilts, so that it is a plane. Unknown where
/// nothing measures the height, and for the slice of a 3D lidar, which has no single height.
struct ScanHeight {
  float base_m = 0.0F;  ///< at the origin of the vehicle's frame, m; 0: unknown
  Eigen::Vector2f slope = Eigen::Vector2f::Zero();  ///< rise per m forward and left

  bool isKnown() const { return base_m > 0.0F; }
  /// `point`: in the vehicle's frame, m.
  float at(const Eigen::Vector2f& point) const { return base_m + slope.dot(point); }
};

/// Hits and clears of one sweep: the only type that is passed from projector to mapper.
struct PlanarScan {
  double stamp = 0.0;  ///< as recorded, s; identifies the scan, may go back
  double time = 0.0;   ///< reference time, s; strictly increasing
  std::string source;  ///< frame of the laser; each source has its own time base
  /// Integrated yaw rate of the gyro at `stamp`, rad, not wrapped; only the difference between two
  /// scans is meaningful.
  std::optional<double> integrated_yaw;
  /// Integrated horizontal acceleration at `stamp`, m/s, in a frame that is rotated from
  /// base_stabilized by `integrated_yaw`; only the difference between two scans is meaningful.
  std::optional<Eigen::Vector2d> integrated_acceleration;
  /// odom_T_base of a pose filter at `stamp`; only the difference between two scans is meaningful.
  std::optional<Pose2> predicted;
  ScanHeight height;
  std::vector<PlanarRay> rays;

  std::size_t hitCount() const {
    std::size_t n = 0;
    for (const PlanarRay& ray : rays) n += ray.hit ? 1U : 0U;
    return n;
  }
};

/// The end points of all hits.
Points hitsOf(const PlanarScan& scan);

}  // namespace kestrel
