// SPDX-License-Identifier: BSD-3-Clause
#include "solid_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "infinity.h"

namespace kestrel {
namespace {

/// The steps of a ray along one axis of the grid.
struct AxisSteps {
  int cell;         ///< current cell
  int step;         ///< -1, 0 or 1
  double next;      ///< distance along the ray to the next cell
  double distance;  ///< along the ray between cells
};

/// `position` in cells, `direction` in cells per meter of the ray. `start`: meters along the ray.
AxisSteps stepsAlong(double position, double direction, double start, int cells) {
  AxisSteps steps;
  // Rounding may put a ray that enters through the border outside of the grid.
  const double at = position + (start > 0.0 ? start * direction : 0.0);
  steps.cell = static_cast<int>(std::clamp(std::floor(at), 0.0, cells - 1.0));
  steps.step = (direction > 0.0) - (direction < 0.0);
  steps.distance = steps.step == 0 ? kInfinity : std::abs(1.0 / direction);
  const double border = steps.cell + (steps.step > 0 ? 1 : 0);
  steps.next = steps.step == 0 ? kInfinity : (border - position) / direction;
  return steps;
}

/// Keeps the part of the ray from `enter` to `leave` that lies between 0 and `cells`.
void clip(double position, double direction, int cells, double& enter, double& leave) {
  if (direction == 0.0) {
    if (position < 0.0 || position > cells) leave = -kInfinity;
    return;
  }
  const double a = -position / direction, b = (cells - position) / direction;
  enter = std::max(enter, std::min(a, b));
  leave = std::min(leave, std::max(a, b));
}

}  // namespace

SolidGrid::SolidGrid(const std::vector<Box>& boxes, const std::vector<Cylinder>& cylinders)
    : boxes_(boxes.begin(), boxes.end()), cylinders_(cylinders.begin(), cylinders.end()) {
  if (boxes_.empty() && cylinders_.empty()) return;
  setLayout();
  fill();
}

void SolidGrid::setLayout() {
  constexpr double kCellSize = 1.0;   // m; smaller cells take longer to traverse
  constexpr double kMaxCells = 1000;  // per axis
  constexpr double kMargin = 0.01;    // m; keeps solids off the border
  Eigen::Vector2d low = Eigen::Vector2d::Constant(kInfinity), high = -low;
  const auto extend = [&](const auto& solid) {
    low = low.cwiseMin(solid.center() - solid.halfExtent());
    high = high.cwiseMax(solid.center() + solid.halfExtent());
  };
  std::for_each(boxes_.begin(), boxes_.end(), extend);
  std::for_each(cylinders_.begin(), cylinders_.end(), extend);
  corner_ = low.array() - kMargin;
  const Eigen::Vector2d extent = (high - corner_).array() + kMargin;
  cell_size_ = std::max(kCellSize, extent.maxCoeff() / kMaxCells);
  size_ = (extent / cell_size_).array().ceil().cast<int>();
}

template <typename Solid>
void SolidGrid::addToCells(const Solid& solid, std::size_t number,
                           std::vector<std::vector<std::size_t>>& cells) const {
  const Eigen::Vector2d low = (solid.center() - solid.halfExtent() - corner_) / cell_size_;
  const Eigen::Vector2d high = (solid.center() + solid.halfExtent() - corner_) / cell_size_;
  // A solid that touches a border belongs to both cells, independent of rounding.
  constexpr double kTolerance = 1e-6;  // of a cell
  const double half_cell = (0.5 + kTolerance) * cell_size_;
  const auto from = [&](int axis) { return std::max(static_cast<int>(low[axis]) - 1, 0); };
  const auto to = [&](int axis) {
    return std::min(static_cast<int>(high[axis]) + 1, size_[axis] - 1);
  };
  for (int y = from(1); y <= to(1); ++y) {
    for (int x = from(0); x <= to(0); ++x) {
      const Eigen::Vector2d center = corner_ + cell_size_ * Eigen::Vector2d(x + 0.5, y + 0.5);
      if (!solid.overlapsCell(center, half_cell)) continue;
      cells[static_cast<std::size_t>(y * size_.x() + x)].push_back(number);
    }
  }
}

void SolidGrid::fill() {
  std::vector<std::vector<std::size_t>> cells(static_cast<std::size_t>(size_.prod()));
  std::size_t number = 0;
  for (const BoxSolid& box : boxes_) addToCells(box, number++, cells);
  for (const CylinderSolid& cylinder : cylinders_) addToCells(cylinder, number++, cells);
  first_.reserve(cells.size() + 1);
  for (const std::vector<std::size_t>& cell : cells) {
    first_.push_back(solids_.size());
    solids_.insert(solids_.end(), cell.begin(), cell.end());
  }
  first_.push_back(solids_.size());
}

void SolidGrid::intersectCell(std::size_t cell, const Ray& ray, RayHit& nearest) const {
  for (std::size_t i = first_[cell]; i < first_[cell + 1]; ++i) {
    const std::size_t number = solids_[i];
    if (number < boxes_.size()) {
      boxes_[number].intersect(ray, nearest);
    } else {
      cylinders_[number - boxes_.size()].intersect(ray, nearest);
    }
  }
}

void SolidGrid::intersect(const Ray& ray, RayHit& nearest) const {
  if (first_.empty()) return;
  const Eigen::Vector2d position = (ray.origin.head<2>() - corner_) / cell_size_;
  const Eigen::Vector2d direction = ray.direction.head<2>() / cell_size_;
  double start = 0.0, end = nearest.distance;
  clip(position.x(), direction.x(), size_.x(), start, end);
  clip(position.y(), direction.y(), size_.y(), start, end);
  if (start > end) return;
  AxisSteps x = stepsAlong(position.x(), direction.x(), start, size_.x());
  AxisSteps y = stepsAlong(position.y(), direction.y(), start, size_.y());
  for (;;) {
    intersectCell(static_cast<std::size_t>(y.cell * size_.x() + x.cell), ray, nearest);
    AxisSteps& axis = x.next < y.next ? x : y;
    if (std::min(nearest.distance, end) <= axis.next) return;
    axis.cell += axis.step;
    if (axis.cell < 0 || axis.cell >= (&axis == &x ? size_.x() : size_.y())) return;
    axis.next += axis.distance;
  }
}

}  // namespace kestrel
