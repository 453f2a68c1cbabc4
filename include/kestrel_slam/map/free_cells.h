// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/tile_map.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// The cells that the beams of a scan pass. Made once, they serve all maps with the same frame and
/// resolution. Beams without a return are left out: they end at the walls of each map.
class FreeCells {
 public:
  struct Tile {
    Cell corner;
    std::array<std::uint32_t, kTileSide> rows{};  ///< one bit for each cell
  };

  FreeCells(const PlanarScan& scan, const Pose2& map_T_base, float cells_per_m,
            std::size_t limit_bytes);

  /// In the order of the beams.
  const std::vector<const Tile*>& tiles() const { return in_order_; }
  /// The memory limit kept a part out.
  bool isFull() const { return full_; }

 private:
  TileMap<Tile> tiles_;
  std::vector<const Tile*> in_order_;
  bool full_ = false;
};

}  // namespace kestrel
