// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// Points in one frame, m.
using Points = std::vector<Eigen::Vector2f>;

/// One beam in the gravity-aligned frame of the vehicle (x forward, y left, m), at the scan's
/// reference time.
struct PlanarRay {
  Eigen::Vector2f origin;  ///< where the laser was when it measured this beam
  Eigen::Vector2f end;     ///< the return, or how far the beam certainly met nothing
  bool hit;                ///< true: something was hit at `end`; false: the beam only clears
  /// Of a hit: the map has it already. It keeps its cell from being cleared, and adds nothing.
  bool known = false;
};

/// The one type between projector and mapper: hits and clears of one sweep.
struct PlanarScan {
  double stamp = 0.0;  ///< as recorded, s; the scan's name, need not be monotone
  double time = 0.0;   ///< reference time on a monotone time base, s
  std::optional<double>
      integrated_yaw;  ///< integrated turn rate of the gyro at `stamp`, rad, not
                       ///< wrapped: only the difference between two scans has a meaning
  /// Integrated horizontal acceleration at `stamp`, m/s, in the frame in which `integrated_yaw`
  /// counts: only the difference between two scans has a meaning.
  std::optional<Eigen::Vector2d> integrated_acceleration;
  /// odom_T_base of a pose filter at `stamp`: only the difference between two scans has a meaning.
  std::optional<Pose2> predicted;
  std::vector<PlanarRay> rays;

  std::size_t hitCount() const {
    std::size_t n = 0;
    for (const PlanarRay& ray : rays) n += ray.hit ? 1U : 0U;
    return n;
  }
};

/// The ends of all rays that hit something.
Points hitsOf(const PlanarScan& scan);

}  // namespace kestrel
