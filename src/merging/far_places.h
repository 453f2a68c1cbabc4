// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace kestrel {

/// How many of the points are at least so far apart from each other. The first two are those that
/// are farthest apart: a point between them would hide both.
std::size_t countFarPlaces(const std::vector<Eigen::Vector2d>& points, double apart_m);

}  // namespace kestrel
