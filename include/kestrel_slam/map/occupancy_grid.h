// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/map/occupancy_grid_config.h"
#include "kestrel_slam/map/tile_map.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// Value and gradient (1/m) of the interpolated occupancy (paper 001 eq. 4-6).
struct InterpolatedValue {
  float value;
  Eigen::Vector2f gradient;
};

/// Growing log-odds occupancy grid (paper 000 eq. 6-10) with multi-resolution levels.
///
/// Level 0 holds the evidence; a cell of level k covers 2^k × 2^k of its cells and holds their
/// maximum, so that a coarse value bounds the fine ones. Memory follows the visited area.
class OccupancyGrid {
 public:
  static constexpr int kLevels = 3;  ///< 5, 10 and 20 cm at the default resolution

  /// What one insertion changed, for surfaces that are derived from the grid.
  struct Changes {
    struct Hit {
      Cell cell;
      Eigen::Vector2f point;  ///< the end point in the map, m
    };
    std::vector<Hit> hits;          ///< every hit beam, in the order of the scan
    std::vector<Cell> became_free;  ///< cells that were occupied before
    bool full = false;              ///< the memory limit kept something out
  };

  explicit OccupancyGrid(const OccupancyGridConfig& config);

  /// Inserts a scan: every cell that a beam passes is updated once with the miss probability, every
  /// cell with an end point once with the hit probability; where both occur the hit wins. The cell
  /// of a hit that is marked as known stays as it is.
  /// In established free space a hit counts half, as that of somebody who walks by, unless so much
  /// of the scan does not fit that it is a `new_view`: from another height, or of a changed room.
  /// The result stays valid until the next call.
  const Changes& insert(const PlanarScan& scan, const Pose2& map_T_base, bool new_view = false);

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
  bool isOccupied(const Cell& cell) const {
    const Tile* tile = tiles_.find(cell);
    return tile != nullptr && tile->log_odds[offsetInTile(cell)] > 0;
  }
  /// Occupancy probability of a cell; 0.5 where nothing is known.
  double probability(const Cell& cell) const;
  /// Maximum occupancy probability of a cell of level `level` (cell coordinates of that level).
  double levelProbability(int level, const Cell& cell) const {
    return probabilities_[levelLogOdds(level, cell)];
  }

  /// Bilinear occupancy and its gradient at a point of the map (paper 001 eq. 4-6), on a level.
  InterpolatedValue interpolate(int level, const Eigen::Vector2f& point) const;

  MapSnapshot snapshot() const;
  std::size_t memoryBytes() const { return tiles_.memoryBytes(); }

 private:
  using Row = std::uint32_t;  ///< one bit a cell of a row of a tile
  static_assert(kTileSide == 32, "one row of a tile is one Row");

  struct Tile {
    std::array<std::int16_t, kTileCells> log_odds{};  ///< fixed point; 0: unknown
    std::array<std::int16_t, kTileCells / 4> level1{};
    std::array<std::int16_t, kTileCells / 16> level2{};
    std::array<Row, kTileSide> occupied{};
    std::array<Row, kTileSide> missed{};  ///< of the scan being inserted
    std::array<Row, kTileSide> hit{};
    Cell corner;
    bool touched = false;
  };

  Tile* touch(const Cell& cell);
  void markHits(const PlanarScan& scan, const Pose2& map_T_base);
  void markMisses(const PlanarScan& scan, const Pose2& map_T_base);
  void keepKnown(const PlanarScan& scan, const Pose2& map_T_base);
  void traceRay(const Eigen::Vector2f& origin, const Eigen::Vector2f& end);
  void apply(Tile& tile, std::int16_t hit_in_free);
  void applyMisses(Tile& tile);
  static void pool(Tile& tile);
  std::int16_t levelLogOdds(int level, const Cell& cell) const {
    const Tile* tile = tiles_.find({cell.x * (1 << level), cell.y * (1 << level)});
    if (tile == nullptr) return 0;
    const unsigned side = static_cast<unsigned>(kTileSide) >> level;
    const std::size_t offset = (static_cast<unsigned>(cell.y) & (side - 1U)) * side +
                               (static_cast<unsigned>(cell.x) & (side - 1U));
    if (level == 0) return tile->log_odds[offset];
    return level == 1 ? tile->level1[offset] : tile->level2[offset];
  }

  double resolution_m_;
  float resolution_;
  float inverse_resolution_;
  std::int16_t hit_, miss_, min_, max_;  ///< fixed-point log odds
  const double* probabilities_;          ///< by fixed-point log odds, negative ones before it
  TileMap<Tile> tiles_;
  std::vector<Tile*> touched_;
  Changes changes_;
};

}  // namespace kestrel
