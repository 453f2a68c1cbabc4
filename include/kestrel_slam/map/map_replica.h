// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/map/tile_map.h"

namespace kestrel {

/// The values of one tile of a map, row by row: the probability in % that the cell is occupied, or
/// -1 if it is unknown. Occupied cells have more than 50, free ones less.
struct TileImage {
  Cell corner;  ///< lower left cell
  std::array<std::int8_t, kTileCells> cells;
};

/// A rectangle of cells: x in [x0, x1), y in [y0, y1).
struct CellRectangle {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  bool empty() const { return x1 <= x0 || y1 <= y0; }
  void extend(int x, int y);
};

/// A copy of a map that is kept up to date tile by tile. The matching thread only copies the
/// tiles that changed; the copy is completed by the thread that publishes it.
class MapReplica {
 public:
  explicit MapReplica(double resolution_m) : resolution_m_(resolution_m) {}

  void update(const TileImage& tile);

  /// The tiles that follow are all those of another map. endMap() compares it with the map before,
  /// so that only what is different is a change: a loop moves few walls.
  void beginMap();
  void endMap();

  /// The known part, as OccupancyGrid::snapshot.
  MapSnapshot snapshot() const;
  /// The same part with probabilities in %, and -1.
  MapSnapshot probabilities() const;

  /// The known part, in cells of the map frame.
  const CellRectangle& known() const { return known_; }
  /// The cells whose value {-1, 0, 100} changed since the last call, and their values, row by row.
  CellRectangle takeChanged();
  std::vector<std::int8_t> valuesIn(const CellRectangle& part) const;

 private:
  struct Tile {
    std::array<std::int8_t, kTileCells> cells;
    Tile() { cells.fill(MapSnapshot::kUnknown); }
  };
  using Tiles = TileMap<Tile>;

  std::vector<std::int8_t> percentIn(const CellRectangle& part) const;
  MapSnapshot mapOf(std::vector<std::int8_t> cells) const;
  void noteDifferences(const Cell& corner, const Tile& a, const Tile& b);

  double resolution_m_;
  Tiles tiles_{SIZE_MAX};
  std::optional<Tiles> before_;  ///< the map before, while another one comes
  CellRectangle known_, changed_;
};

}  // namespace kestrel
