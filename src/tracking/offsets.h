// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/tracking/cell_map.h"

namespace kestrel {

/// Calls `visit(offset)` for all offsets up to `radius` in each direction, until it returns true.
template <int D, typename Visit>
bool anyAround(int radius, Visit visit) {
  GridIndex<D> offset = GridIndex<D>::Constant(-radius);
  for (;;) {
    if (visit(offset)) return true;
    int axis = 0;
    while (axis < D && ++offset(axis) > radius) offset(axis++) = -radius;
    if (axis == D) return false;
  }
}

}  // namespace kestrel
