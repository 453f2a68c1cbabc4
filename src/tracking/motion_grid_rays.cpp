// SPDX-License-Identifier: BSD-3-Clause
// The parts of MotionGrid that look at many cells: what is near a return, and what a beam passes.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "beam_overlap.h"
#include "kestrel_slam/tracking/motion_grid.h"
#include "offsets.h"

namespace kestrel {
namespace {

constexpr float kMaxSpacing = 1.0F;  ///< m; of two returns of one surface

/// The steps of a walk until it leaves a tile, or has made all steps along an axis.
class TileWalk {
 public:
  /// `left`: steps to the last cell along each axis.
  TileWalk(CellWalk<2>& walk, int (&left)[2]) : walk_(walk), left_(left) {
    for (int i = 0; i < 2; ++i) {
      const int within = walk.index[i] & (kTileSide - 1);
      const int to_border = walk.step[i] > 0 ? kTileSide - within : within + 1;
      steps_[i] = left[i] > 0 ? std::min(to_border, left[i]) : to_border;
    }
  }

  /// Calls `visit(cell)` for each cell. `cell`: the first, in a tile.
  template <typename CellData, typename Visit>
  void run(CellData* cell, Visit visit) {
    // Copies, which the compiler keeps in registers.
    double x = walk_.next[0], y = walk_.next[1];
    const double per_x = walk_.per_cell[0], per_y = walk_.per_cell[1];
    const std::ptrdiff_t column = walk_.step[0], row = walk_.step[1] * kTileSide;
    int x_steps = steps_[0], y_steps = steps_[1];
    for (;;) {
      visit(*cell);
      if (y < x) {
        if (--y_steps == 0) break;
        y += per_y;
        cell += row;
      } else {
        if (--x_steps == 0) break;
        x += per_x;
        cell += column;
      }
    }
    finish(0, x, steps_[0] - x_steps, x_steps == 0);
    finish(1, y, steps_[1] - y_steps, y_steps == 0);
  }

 private:
  void finish(int axis, double next, int steps, bool is_border) {
    walk_.index[axis] += steps * walk_.step[axis];
    left_[axis] -= steps;
    if (is_border) next = left_[axis] > 0 ? next + walk_.per_cell[axis] : CellWalk<2>::kNever;
    walk_.next[axis] = next;
  }

  CellWalk<2>& walk_;
  int (&left_)[2];
  int steps_[2];
};

}  // namespace

/// What is occupied within the distance. If something is static, the rest may be missing.
template <int D>
typename MotionGrid<D>::Surroundings MotionGrid<D>::surroundingsOf(const Vector& point,
                                                                   double distance) const {
  const auto reach = static_cast<float>(distance / config_.resolution_m);
  const Vector in_cells = point / static_cast<float>(config_.resolution_m);
  const auto cellOf = [](float coordinate) { return floorToInt(coordinate); };
  const Index low = (in_cells - Vector::Constant(reach)).unaryExpr(cellOf);
  const Index high = (in_cells + Vector::Constant(reach)).unaryExpr(cellOf);
  Surroundings result;
  anyKnown<D>(cells_, low, high, [&](const Index& index, const CellData& cell) {
    if (!(cell.static_odds > occupied_)) return false;
    const Vector from = index.template cast<float>() - in_cells;
    const Vector gap = from.cwiseMax(-from - Vector::Ones()).cwiseMax(0.0F);
    if (gap.norm() > reach) return false;
    (hasStopped(cell) ? result.has_stopped : isNew(cell) ? result.is_new : result.is_static) = true;
    return result.is_static;
  });
  return result;
}

/// The surface is wider than the returns: noise moves it into the neighboring cells, and at a
/// grazing angle it goes on between the returns of two neighboring beams, in cells that the farther
/// beam passes. These cells are not measured as free by this scan.
template <int D>
void MotionGrid<D>::protectSurface(const std::vector<GridRay<D>>& rays) {
  Index last = Index::Constant(std::numeric_limits<int>::max());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (result_.motion[i] == CellMotion::kNone) continue;
    const Index& index = ends_[i].index;
    if (index == last) continue;
    last = index;
    protectAround(index);
    const bool has_neighbor = D == 2 && i > 0 && result_.motion[i - 1] != CellMotion::kNone;
    // Between cells side by side there is nothing.
    if (!has_neighbor || (index - ends_[i - 1].index).cwiseAbs().sum() <= 1) continue;
    if ((rays[i].end - rays[i - 1].end).norm() > kMaxSpacing) continue;
    traverse<D>(rays[i - 1].end * per_meter_, rays[i].end * per_meter_,
                [this](const Index& between) {
                  protectCell(between);
                  return true;
                });
  }
}

template <int D>
void MotionGrid<D>::protectAround(const Index& index) {
  if constexpr (D == 2) {
    constexpr int kLast = kTileSide - 1;
    const int x = index.x() & kLast, y = index.y() & kLast;
    auto* tile = x > 0 && x < kLast && y > 0 && y < kLast ? cells_.obtainTile(index) : nullptr;
    if (tile != nullptr) {  // all are in one tile
      CellData* cell = &(*tile)[offsetInTile({index.x(), index.y()})];
      cell[-kTileSide].scan = cell[-1].scan = cell[1].scan = cell[kTileSide].scan = scan_;
      return;
    }
  }
  for (int axis = 0; axis < D; ++axis) {
    protectCell(index + Index::Unit(axis));
    protectCell(index - Index::Unit(axis));
  }
}

template <int D>
void MotionGrid<D>::protectCell(const Index& index) {
  CellData* cell = cells_.obtain(index);
  if (cell != nullptr) cell->scan = scan_;
}

template <int D>
void MotionGrid<D>::clearAlong(const std::vector<GridRay<D>>& rays) {
  std::vector<float> shared;
  if constexpr (D == 2) shared = sharedWays(rays, static_cast<float>(config_.resolution_m));
  shared.resize(rays.size(), 0.0F);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!ends_[i].is_usable || shared[i] >= 1.0F) continue;
    const Vector& origin = rays[i].origin;
    const Vector from =
        shared[i] > 0.0F ? (origin + shared[i] * (rays[i].end - origin)).eval() : origin;
    if constexpr (D == 2) {
      // Of most beams, only the end is not shared, and the cell before a return is protected.
      const int steps = (ends_[i].index - indexOf(from)).cwiseAbs().sum();
      if (steps <= (rays[i].hit ? 1 : 0)) continue;
    }
    passAlong(rays[i], from);
  }
}

/// The rows of table 1 and 2 with a free measurement, for the cells of a ray from `first` on. In
/// the plane, a tile is looked up once for all cells that the beam passes in it.
template <int D>
void MotionGrid<D>::passAlong(const GridRay<D>& ray, const Vector& first) {
  const Vector from = first * per_meter_, to = ray.end * per_meter_;
  const std::uint32_t scan = scan_;
  if constexpr (D == 2) {
    CellWalk<2> walk(from, to);
    int left[2] = {std::abs(walk.last[0] - walk.index[0]), std::abs(walk.last[1] - walk.index[1])};
    while (left[0] + left[1] > 0) {
      const Index index(walk.index[0], walk.index[1]);
      auto* tile = cells_.findBlock(index);
      if (tile == nullptr) tile = cells_.obtainTile(index);
      result_.full |= tile == nullptr;
      if (tile == nullptr) return;
      TileWalk(walk, left).run(&(*tile)[cells_.offsetOf(index)], [&](CellData& cell) {
        if (cell.scan < scan) passCell(cell, ray.presumed);
      });
    }
  } else {
    CellWalk<D> walk(from, to);
    const float fall = ray.end.z() - first.z();
    for (float height = first.z(); walk.remaining > 0;) {
      CellData* cell = cells_.obtain(Eigen::Map<const Index>(walk.index));
      result_.full |= cell == nullptr;
      if (cell == nullptr) return;
      if (cell->scan < scan) passCell(*cell, ray.presumed);
      const float entry = height;
      height = first.z() + static_cast<float>(walk.advance()) * fall;
      cell->lowest_pass = std::min({cell->lowest_pass, entry, height});
    }
  }
}

template MotionGrid<2>::Surroundings MotionGrid<2>::surroundingsOf(const Vector&, double) const;
template void MotionGrid<2>::protectSurface(const std::vector<GridRay<2>>&);
template void MotionGrid<2>::clearAlong(const std::vector<GridRay<2>>&);
template MotionGrid<3>::Surroundings MotionGrid<3>::surroundingsOf(const Vector&, double) const;
template void MotionGrid<3>::protectSurface(const std::vector<GridRay<3>>&);
template void MotionGrid<3>::clearAlong(const std::vector<GridRay<3>>&);

}  // namespace kestrel
