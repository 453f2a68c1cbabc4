// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "likelihood_image.h"
#include "search_grid.h"

namespace kestrel {

/// Number of points that are summed at once.
constexpr int kChunkPoints = 32;

/// A rectangle of adjacent windows for a point at (0, 0): starting at (dx, dy), 2^level apart.
struct Windows {
  int level, dx, dy, columns, rows;
};

/// Adds to `sums`, row by row, the window values of `count` points (at most kChunkPoints).
void addWindows(const LikelihoodImage& image, const Windows& windows, const PointCell* points,
                int count, int* sums);

}  // namespace kestrel
