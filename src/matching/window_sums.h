// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "likelihood_image.h"
#include "search_grid.h"

namespace kestrel {

/// Points whose sums are looked at in one go.
constexpr int kChunkPoints = 32;

/// Windows side by side that a point at (0, 0) sees: from (dx, dy) on, 2^level apart.
struct Windows {
  int level, dx, dy, columns, rows;
};

/// Adds to `sums`, row by row, what `count` points, at most kChunkPoints, see at every window.
void addWindows(const LikelihoodImage& image, const Windows& windows, const PointCell* points,
                int count, int* sums);

}  // namespace kestrel
