// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "kestrel_slam/map/map_snapshot.h"

namespace kestrel {

/// Where a ray from `start` in the direction `direction` (any length) enters the first occupied
/// cell, in map coordinates, m. Unknown cells do not stop it. `start` itself, if it is in an
/// occupied cell. Nothing if the ray leaves the map, or if a number is not finite.
std::optional<Eigen::Vector2d> firstObstacle(const MapSnapshot& map, const Eigen::Vector2d& start,
                                             const Eigen::Vector2d& direction);

}  // namespace kestrel
