// SPDX-License-Identifier: BSD-3-Clause
#include "far_places.h"

#include <algorithm>
#include <limits>

namespace kestrel {
namespace {

/// From the nearest one.
double distanceTo(const std::vector<Eigen::Vector2d>& places, const Eigen::Vector2d& point) {
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& place : places) least = std::min(least, (place - point).norm());
  return least;
}

Eigen::Vector2d farthestFrom(const std::vector<Eigen::Vector2d>& places,
                             const std::vector<Eigen::Vector2d>& points) {
  return *std::max_element(points.begin(), points.end(), [&](const auto& a, const auto& b) {
    return distanceTo(places, a) < distanceTo(places, b);
  });
}

/// One of the two points that are farthest apart.
Eigen::Vector2d endOf(const std::vector<Eigen::Vector2d>& points) {
  const auto reach = [&](const Eigen::Vector2d& point) {
    return (farthestFrom({point}, points) - point).norm();
  };
  return *std::max_element(points.begin(), points.end(),
                           [&](const auto& a, const auto& b) { return reach(a) < reach(b); });
}

}  // namespace

std::size_t countFarPlaces(const std::vector<Eigen::Vector2d>& points, double apart_m) {
  if (points.empty()) return 0;
  std::vector<Eigen::Vector2d> places = {endOf(points)};
  for (;;) {
    const Eigen::Vector2d next = farthestFrom(places, points);
    if (distanceTo(places, next) < apart_m) return places.size();
    places.push_back(next);
  }
}

}  // namespace kestrel
