// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/free_cells.h"
#include "kestrel_slam/map/map_replica.h"
#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/map/occupancy_grid_config.h"
#include "kestrel_slam/map/tile_map.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

struct RayRun;

/// Value and gradient (1/m) of the interpolated occupancy [Kohlbrecher 2011, eq. 4-6].
struct InterpolatedValue {
  float value;
  Eigen::Vector2f gradient;
};

/// Growing log-odds occupancy grid [MAV SLAM 2013, eq. 6-10] with multi-resolution levels.
///
/// Level 0 stores the log odds. A cell of level k covers 2^k × 2^k cells of level 0 and has their
/// maximum, so that it is an upper bound. The memory is proportional to the visited area.
class OccupancyGrid {
 public:
  static constexpr int kLevels = 3;  ///< 5, 10 and 20 cm at the default resolution

  /// Changes of one insertion, for data that is derived from the grid.
  struct Changes {
    struct Hit {
      Cell cell;
      Eigen::Vector2f point;  ///< end point in the map frame, m
      bool in_free = false;   ///< the cell was known to be free
    };
    std::vector<Hit> hits;          ///< all inserted hits, in the order of the scan
    std::vector<Cell> became_free;  ///< cells that were occupied before the insertion
    bool full = false;              ///< a part was not inserted because of the memory limit
  };

  explicit OccupancyGrid(const OccupancyGridConfig& config);
  /// `budget`: shared with other parts of the map; replaces the memory limit of `config`.
  OccupancyGrid(const OccupancyGridConfig& config, SharedBudget budget);

  /// Inserts a scan. Every cell that a beam passes is updated once with the miss probability. Every
  /// cell with an end point is updated once with the hit probability; a hit overrides misses. The
  /// cell of a hit that is marked as known is not changed.
  /// A hit in established free space counts half, because it may be a person who walks by. It
  /// counts fully if `new_view` is true: so much of the scan disagrees with the map that the height
  /// of the slice or the room must have changed.
  /// The result is valid until the next call.
  const Changes& insert(const PlanarScan& scan, const Pose2& map_T_base, bool new_view = false);
  /// The same with the freeCells of a grid with the same resolution.
  const Changes& insert(const PlanarScan& scan, const Pose2& map_T_base, const FreeCells& free,
                        bool new_view);
  FreeCells freeCells(const PlanarScan& scan, const Pose2& map_T_base) const;

  void clear();

  Cell cellAt(const Eigen::Vector2f& point) const {
    return {floorToInt(point.x() * inverse_resolution_),
            floorToInt(point.y() * inverse_resolution_)};
  }
  Eigen::Vector2f centerOf(const Cell& cell) const {
    return {(static_cast<float>(cell.x) + 0.5F) * resolution_,
            (static_cast<float>(cell.y) + 0.5F) * resolution_};
  }
  float resolution() const { return resolution_; }

  bool isKnown(const Cell& cell) const {
    const Tile* tile = tiles_.find(cell);
    return tile != nullptr && tile->log_odds[offsetInTile(cell)] != 0;
  }
  /// Whether a return in this cell would be a surprise or confirm a wall: the cell is known, or it
  /// is presumably free because beams without a return passed it.
  bool isKnownOrPresumed(const Cell& cell) const {
    const Tile* tile = tiles_.find(cell);
    if (tile == nullptr) return false;
    const std::size_t offset = offsetInTile(cell);
    return tile->log_odds[offset] != 0 ||
           (tile->presumed[offset >> kTileShift] >> (offset & (kTileSide - 1U)) & 1U) != 0U;
  }
  bool isOccupied(const Cell& cell) const {
    const Tile* tile = tiles_.find(cell);
    return tile != nullptr && tile->log_odds[offsetInTile(cell)] > 0;
  }
  /// Occupancy probability of a cell; 0.5 if it is unknown.
  double probability(const Cell& cell) const;
  /// Maximum occupancy probability of a cell of level `level`, in cell coordinates of that level.
  double levelProbability(int level, const Cell& cell) const {
    return probabilities_[levelLogOdds(level, cell)];
  }

  /// Bilinear occupancy and its gradient at a point of the map frame (m), on a level [Kohlbrecher
  /// 2011, eq. 4-6].
  InterpolatedValue interpolate(int level, const Eigen::Vector2f& point) const;

  MapSnapshot snapshot() const;

  /// Appends the images of at most `max_tiles` tiles that changed since they were last taken.
  /// Returns false if none is left. For one MapReplica only.
  bool takeChangedTiles(std::size_t max_tiles, std::vector<TileImage>& images);
  std::size_t memoryBytes() const { return tiles_.memoryBytes(); }

 private:
  using Row = std::uint32_t;  ///< one bit per cell in a row of a tile
  static_assert(kTileSide == 32, "Row has one bit per cell");

  struct Tile {
    std::array<std::int16_t, kTileCells> log_odds{};  ///< fixed point; 0: unknown
    std::array<Row, kTileSide> occupied{};
    std::array<Row, kTileSide> missed{};    ///< passed by a beam of the current scan
    std::array<Row, kTileSide> hit{};       ///< hit by a beam of the current scan
    std::array<Row, kTileSide> presumed{};  ///< presumably free
    Cell corner;
    bool touched = false;
    bool changed = false;  ///< in `changed_tiles_`
  };

  Tile* touch(const Cell& cell);
  void markHits(const PlanarScan& scan, const Pose2& map_T_base);
  void markMisses(const FreeCells& free);
  void markMissesUpToWalls(const PlanarScan& scan, const Pose2& map_T_base);
  void removeMissesOfKnownHits(const PlanarScan& scan, const Pose2& map_T_base);
  static int stepsToWall(const Tile& tile, const RayRun& run);
  void apply(Tile& tile, std::int16_t hit_in_free);
  void applyMisses(Tile& tile);
  std::int16_t levelLogOdds(int level, const Cell& cell) const {
    const Cell corner{cell.x * (1 << level), cell.y * (1 << level)};
    const Tile* tile = tiles_.find(corner);
    if (tile == nullptr) return 0;
    const std::int16_t* const first = tile->log_odds.data() + offsetInTile(corner);
    if (level == 0) return *first;
    return level == 1 ? maximum<2>(first) : maximum<4>(first);
  }
  /// The maximum of a square of cells of a tile.
  template <int side>
  static std::int16_t maximum(const std::int16_t* first) {
    std::int16_t result = *first;
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column)
        result = std::max(result, first[row * kTileSide + column]);
    }
    return result;
  }

  double resolution_m_;
  float resolution_;
  float inverse_resolution_;
  std::int16_t hit_, miss_, min_, max_;  ///< fixed-point log odds
  const double* probabilities_;          ///< indexed by fixed-point log odds, also negative ones
  TileMap<Tile> tiles_;
  std::vector<Tile*> touched_;
  std::vector<Tile*> changed_tiles_;  ///< since they were last taken
  Changes changes_;
};

}  // namespace kestrel
