// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/obstacle_ray.h"

#include <cmath>
#include <limits>

namespace kestrel {
namespace {

/// Walks from cell to cell along one axis.
struct Axis {
  Axis(double position, double direction)
      : cell(static_cast<long>(std::floor(position))), step(direction < 0.0 ? -1 : 1) {
    if (direction == 0.0) return;
    const double border = static_cast<double>(cell) + (step > 0 ? 1.0 : 0.0);
    next = (border - position) / direction;
    period = 1.0 / std::abs(direction);
  }

  double advance() {
    const double way = next;
    cell += step;
    next += period;
    return way;
  }

  long cell;
  int step;
  double next = std::numeric_limits<double>::infinity();  ///< way to the next border, cells
  double period = 0.0;                                    ///< way between two borders
};

bool isInside(const MapSnapshot& map, long column, long row) {
  return column >= 0 && row >= 0 && column < map.width && row < map.height;
}

/// Whether the ray can still reach the map.
bool mayEnter(const Axis& axis, int cells) {
  const bool moves = std::isfinite(axis.next);
  if (axis.cell < 0) return moves && axis.step > 0;
  if (axis.cell >= cells) return moves && axis.step < 0;
  return true;
}

}  // namespace

std::optional<Eigen::Vector2d> firstObstacle(const MapSnapshot& map, const Eigen::Vector2d& start,
                                             const Eigen::Vector2d& direction) {
  constexpr double kMaxCells = 1e6;  // a start farther away cannot be meant
  const Eigen::Vector2d unit = direction.normalized();
  const Eigen::Vector2d from =
      (start - Eigen::Vector2d(map.origin_x, map.origin_y)) / map.resolution_m;
  if (!unit.allFinite() || unit.isZero() || !(from.cwiseAbs().maxCoeff() < kMaxCells)) {
    return std::nullopt;
  }
  Axis x(from.x(), unit.x()), y(from.y(), unit.y());
  double way = 0.0;
  while (mayEnter(x, map.width) && mayEnter(y, map.height)) {
    if (isInside(map, x.cell, y.cell) &&
        map.at(static_cast<int>(x.cell), static_cast<int>(y.cell)) == MapSnapshot::kOccupied) {
      return start + way * map.resolution_m * unit;
    }
    way = x.next < y.next ? x.advance() : y.advance();
  }
  return std::nullopt;
}

}  // namespace kestrel
