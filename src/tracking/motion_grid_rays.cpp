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

/// 0, -1, 1, -2, 2, ...: the nearest cells first.
int alternating(int i) { return i % 2 == 0 ? i / 2 : -(i + 1) / 2; }

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

  /// Calls `visit(offset)` for each cell, with its offset in the tile.
  template <typename Visit>
  void run(std::size_t offset, Visit visit) {
    // Copies, which the compiler keeps in registers.
    double x = walk_.next[0], y = walk_.next[1];
    const double per_x = walk_.per_cell[0], per_y = walk_.per_cell[1];
    const std::size_t column = static_cast<std::size_t>(walk_.step[0]);
    const std::size_t row = static_cast<std::size_t>(walk_.step[1] * kTileSide);
    int x_steps = steps_[0], y_steps = steps_[1];
    for (;;) {
      visit(offset);
      if (y < x) {
        if (--y_steps == 0) break;
        y += per_y;
        offset += row;
      } else {
        if (--x_steps == 0) break;
        x += per_x;
        offset += column;
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
  const Index center = indexOf(point);
  const auto reach = static_cast<float>(distance / config_.resolution_m);
  const Vector in_cells = point / static_cast<float>(config_.resolution_m);
  Surroundings result;
  const int radius = static_cast<int>(std::ceil(reach));
  const auto look = [&](const Index& index) {
    const CellData* cell = cells_.find(index);
    if (cell == nullptr || stateOf(*cell) != CellState::kOccupied) return;
    (hasStopped(*cell) ? result.has_stopped
     : isNew(*cell)    ? result.is_new
                       : result.is_static) = true;
  };
  // Distance from the point to the cells of this index, along an axis.
  const auto gapAt = [&](int axis, int index) {
    const float low = static_cast<float>(index) - in_cells(axis);
    return std::max(std::max(low, -low - 1.0F), 0.0F);
  };
  if constexpr (D == 2) {
    for (int i = 0; i <= 2 * radius && !result.is_static; ++i) {
      const int y = center.y() + alternating(i);
      const float up = gapAt(1, y);
      if (up > reach) continue;
      for (int j = 0; j <= 2 * radius && !result.is_static; ++j) {
        const int x = center.x() + alternating(j);
        const float aside = gapAt(0, x);
        if (std::sqrt(aside * aside + up * up) <= reach) look({x, y});
      }
    }
  } else {
    anyAround<D>(radius, [&](const Index& offset) {
      const Index index = center + offset;
      const Vector gap(gapAt(0, index.x()), gapAt(1, index.y()), gapAt(2, index.z()));
      if (gap.norm() <= reach) look(index);
      return result.is_static;
    });
  }
  return result;
}

/// The surface is wider than the returns: noise moves it into the neighboring cells, and at a
/// grazing angle it goes on between the returns of two neighboring beams, in cells that the farther
/// beam passes. These cells are not measured as free by this scan.
template <int D>
void MotionGrid<D>::protectSurface(const std::vector<GridRay<D>>& rays) {
  const auto inverse = static_cast<float>(1.0 / config_.resolution_m);
  Index last = Index::Constant(std::numeric_limits<int>::max());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (result_.motion[i] == CellMotion::kNone) continue;
    const Index index = indexOf(rays[i].end);
    if (index == last) continue;
    last = index;
    protectAround(index);
    const bool has_neighbor = D == 2 && i > 0 && result_.motion[i - 1] != CellMotion::kNone;
    // Between cells side by side there is nothing.
    if (!has_neighbor || (index - indexOf(rays[i - 1].end)).cwiseAbs().sum() <= 1) continue;
    if ((rays[i].end - rays[i - 1].end).norm() > kMaxSpacing) continue;
    traverse<D>(rays[i - 1].end * inverse, rays[i].end * inverse, [this](const Index& between) {
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
  std::vector<float> from;
  if constexpr (D == 2) from = sharedRanges(rays, static_cast<float>(config_.resolution_m));
  from.resize(rays.size(), 0.0F);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (isUsable(rays[i])) updateMiss(rays[i], from[i]);
  }
}

/// The rows of table 1 and 2 with a free measurement, for the cells of a ray that are farther than
/// `from`, m.
template <int D>
void MotionGrid<D>::updateMiss(const GridRay<D>& ray, float from) {
  const auto inverse = static_cast<float>(1.0 / config_.resolution_m);
  const Vector along = ray.end - ray.origin;
  const Vector first = from > 0.0F ? (ray.origin + from / along.norm() * along).eval() : ray.origin;
  passAlong(first * inverse, ray.end * inverse, ray.presumed);
}

/// In the plane, a tile is looked up once for all cells that the beam passes in it.
template <int D>
void MotionGrid<D>::passAlong(const Vector& from, const Vector& to, bool presumed) {
  if constexpr (D == 2) {
    CellWalk<2> walk(from, to);
    int left[2] = {std::abs(walk.last[0] - walk.index[0]), std::abs(walk.last[1] - walk.index[1])};
    while (left[0] + left[1] > 0) {
      const Index index(walk.index[0], walk.index[1]);
      auto* tile = cells_.obtainTile(index);
      result_.full |= tile == nullptr;
      if (tile == nullptr) return;
      TileWalk(walk, left).run(offsetInTile({index.x(), index.y()}), [&](std::size_t offset) {
        CellData& cell = (*tile)[offset];
        if (cell.scan != scan_ && !cell.is_clear) passCell(cell, presumed);
      });
    }
  } else {
    traverse<D>(from, to, [&](const Index& index) {
      CellData* cell = cells_.obtain(index);
      result_.full |= cell == nullptr;
      if (cell == nullptr) return false;
      if (cell->scan != scan_ && !cell->is_clear) passCell(*cell, presumed);
      return true;
    });
  }
}

template MotionGrid<2>::Surroundings MotionGrid<2>::surroundingsOf(const Vector&, double) const;
template void MotionGrid<2>::protectSurface(const std::vector<GridRay<2>>&);
template void MotionGrid<2>::clearAlong(const std::vector<GridRay<2>>&);
template MotionGrid<3>::Surroundings MotionGrid<3>::surroundingsOf(const Vector&, double) const;
template void MotionGrid<3>::protectSurface(const std::vector<GridRay<3>>&);
template void MotionGrid<3>::clearAlong(const std::vector<GridRay<3>>&);

}  // namespace kestrel
