// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bound_images.h"
#include "strip_bounds.h"

namespace kestrel {

/// A value for each block of a tile, row by row.
using TileSums = std::array<std::uint16_t, BoundImages::kTileBlocks * BoundImages::kTileBlocks>;

/// The bounds of all blocks of a tile: the sums of the bounds of the points.
TileSums boundsIn(const BoundImages& images, const std::vector<RotatedPoint>& turned,
                  const BoundImages::Tile& tile);

}  // namespace kestrel
