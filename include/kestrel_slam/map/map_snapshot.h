// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace kestrel {

/// A copy of the known part of a map, in the layout and values of nav_msgs/OccupancyGrid.
struct MapSnapshot {
  static constexpr std::int8_t kUnknown = -1, kFree = 0, kOccupied = 100;

  double resolution_m = 0.05;
  double origin_x = 0.0;  ///< map coordinates of the lower left corner of cell (0, 0), m
  double origin_y = 0.0;
  int width = 0;
  int height = 0;
  std::vector<std::int8_t> cells;  ///< row-major from the lower left corner: {-1, 0, 100}

  bool empty() const { return cells.empty(); }
  std::int8_t at(int column, int row) const {
    return cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                 static_cast<std::size_t>(column)];
  }
};

}  // namespace kestrel
