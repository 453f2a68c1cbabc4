// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/tracking/cell_map.h"

namespace kestrel {

/// Calls `visit(index)` for all cells from `low` to `high`, until it returns true.
template <int D, typename Visit>
bool anyBetween(const GridIndex<D>& low, const GridIndex<D>& high, Visit visit) {
  GridIndex<D> index = low;
  for (;;) {
    for (index(0) = low(0); index(0) <= high(0); ++index(0)) {
      if (visit(GridIndex<D>(index))) return true;
    }
    int axis = 1;
    for (; axis < D && ++index(axis) > high(axis); ++axis) index(axis) = low(axis);
    if (axis == D) return false;
  }
}

/// Calls `visit(index, value)` for the cells from `low` to `high` in blocks of the map that exist,
/// until it returns true. Each block is looked up once.
template <int D, typename Value, typename Visit>
bool anyKnown(const CellMap<D, Value>& cells, const GridIndex<D>& low, const GridIndex<D>& high,
              Visit visit) {
  constexpr int kShift = CellMap<D, Value>::kBlockShift;
  const auto blockOf = [](int index) { return index >> kShift; };
  return anyBetween<D>(low.unaryExpr(blockOf), high.unaryExpr(blockOf), [&](const auto& number) {
    const GridIndex<D> corner = number * (1 << kShift);
    const auto* block = cells.findBlock(corner);
    if (block == nullptr) return false;
    const GridIndex<D> last = corner + GridIndex<D>::Constant((1 << kShift) - 1);
    return anyBetween<D>(corner.cwiseMax(low), last.cwiseMin(high), [&](const auto& index) {
      return visit(index, (*block)[cells.offsetOf(index)]);
    });
  });
}

}  // namespace kestrel
