// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// The pose to_T_from that brings each point of `from` closest to its partner in `to`, in least
/// squares: the closed form of [Umeyama 1991] in the plane, without scale. Both have the same size,
/// at least 1. Points that lie in one place do not tell the yaw; then it is `default_yaw`.
Pose2 alignPoints(const std::vector<Eigen::Vector2d>& from, const std::vector<Eigen::Vector2d>& to,
                  double default_yaw = 0.0);

}  // namespace kestrel
