// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <limits>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

/// The motion of the vehicle that changes the distances of the beams to their walls least: along a
/// straight corridor, or along the arc of a curved one.
struct WeakMotion {
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  ///< unit vector in the map frame
  double turn_rad_m = 0.0;                               ///< turn for each meter along `direction`
  /// Share of the points that constrain it, without the noise of the directions of the walls.
  double constraint = 0.0;

  /// `pose` moved by `distance_m`.
  Pose2 moved(const Pose2& pose, double distance_m) const;
};

/// Which beams show the motion. Unknown space, and walls that appeared in free space (the floor
/// that a tilted laser sees), show nothing for certain. With odometry all beams count: the odometry
/// limits their error, and sparse logs have few.
enum class Beams { kCertain, kAll };

/// The weakest motion of a scan that was matched at `map_T_base`, and how well the scan constrains
/// it. The directions of the walls do not show this well, because they are noisy. So the vehicle is
/// moved by 0.2 m in both directions: the beams that do not fit there constrain the motion.
WeakMotion weakMotion(const Submap& map, const Points& points, const Pose2& map_T_base,
                      Beams which = Beams::kCertain);

/// A distance along a weak motion, as the scan shows it.
struct AlongFit {
  double distance_m = 0.0;
  double variance_m2 = std::numeric_limits<double>::infinity();  ///< infinite: nothing is known
};

/// Finds the distance along `motion` from `start` at which the scan fits best. `limit_m`: largest
/// distance.
AlongFit fitAlong(const Submap& map, const Points& points, const Pose2& start,
                  const WeakMotion& motion, double limit_m, Beams which = Beams::kCertain);

/// How clearly the scan shows that the vehicle is at `map_T_base` and not `distance_m` from there
/// along `motion`, in standard deviations: the squared distances of the same beams to their walls
/// are compared at both places. Negative: it fits better there. 0: no beam shows a difference.
double evidenceAgainst(const Submap& map, const Points& points, const Pose2& map_T_base,
                       const WeakMotion& motion, double distance_m);

}  // namespace kestrel
