// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "kestrel_slam/map/occupancy_grid.h"
#include "kestrel_slam/map/tile_map.h"

namespace kestrel {

/// What of a distance along a wall counts: keeps points from sliding past its end.
constexpr float kAlongWeight = 0.05F;

/// The elements (11, 12, 22) of A = n n' + kAlongWeight t t' of a wall whose direction has the unit
/// twice-angle vector `t2`.
inline Eigen::Vector3f lineShape(const Eigen::Vector2f& t2) {
  const float nx2 = 0.5F * (1.0F - t2.x()), ny2 = 1.0F - nx2, nxy = -0.5F * t2.y();
  return {nx2 + kAlongWeight * ny2, nxy * (1.0F - kAlongWeight), ny2 + kAlongWeight * nx2};
}

/// The surface inside one occupied cell: where its hits lie and which way the wall runs.
struct Surfel {
  Eigen::Vector2f mean;  ///< mean of the end points in the cell, m
  float a11, a12, a22;   ///< information shape A: distance² = e' A e for e = point - mean
  Cell cell;
  float count = 0.0F;  ///< hits in the mean, capped so that the mean can follow changes
  /// Direction of the wall as the scans saw it, summed as (cos, sin) of twice its angle, so that
  /// opposite directions agree; zero where no scan saw neighboring points of a wall.
  Eigen::Vector2f tangent2 = Eigen::Vector2f::Zero();
  /// The same from neighbors so far apart that the match does not trust it: where nothing else
  /// tells the direction, the surfel stays a point, which holds the pose in both directions. But
  /// it is no proof that the wall constrains the direction along itself.
  Eigen::Vector2f sparse2 = Eigen::Vector2f::Zero();
  /// Of the scan that is being added: its hits, and the sum of their differences to the mean.
  float new_hits = 0.0F;
  Eigen::Vector2f new_sum = Eigen::Vector2f::Zero();
  std::uint32_t birth =
      0;  ///< number of the scan that made it, counted from 0 since the last clear
};

/// Whether nothing near tells the direction of the wall: the surfel holds the pose in all.
inline bool isPoint(const Surfel& surfel) {
  constexpr float kPointTrace = 1.5F;  // above that of a line, below that of a point, 2
  return surfel.a11 + surfel.a22 >= kPointTrace;
}

/// What a wall can constrain: the elements (11, 12, 22) of A, or of the line that far neighbors
/// make of a lonely point.
inline Eigen::Vector3f constraintOf(const Surfel& surfel) {
  const float length = isPoint(surfel) ? surfel.sparse2.norm() : 0.0F;
  if (length > 0.0F) return lineShape(surfel.sparse2 / length);
  return {surfel.a11, surfel.a12, surfel.a22};
}

/// Smooth matching surface derived from an OccupancyGrid: which surfel is nearest to any cell.
///
/// There is a surfel exactly in the occupied cells of the grid, which stays the one source of
/// truth. A point finds its surfel by one look-up, up to kReachCells away from it; the distance to
/// the wall through it has sub-cell accuracy and an exact gradient.
class SurfelField {
 public:
  /// How far from a surfel cells still know it: 0.45 m at 5 cm.
  static constexpr int kReachCells = 9;

  SurfelField(float resolution_m, std::size_t limit_bytes);

  /// Follows the changes of the last insertion into `grid`; false where the memory limit kept a
  /// part out.
  bool update(const OccupancyGrid& grid, const OccupancyGrid::Changes& changes);

  /// The surfel nearest to the cell of `point`, or nullptr where none is within reach.
  const Surfel* nearest(const Eigen::Vector2f& point) const {
    const Cell cell{floorToInt(point.x() * inverse_resolution_),
                    floorToInt(point.y() * inverse_resolution_)};
    const Tile* tile = tiles_.find(cell);
    if (tile == nullptr) return nullptr;
    const std::uint32_t id = tile->nearest[offsetInTile(cell)];
    return id == kNone ? nullptr : &surfels_[id];
  }

  /// All surfels whose means lie in `area`, in the order of the tiles.
  std::vector<Surfel> surfelsIn(const Eigen::AlignedBox2f& area) const;

  /// Whether any cell near `cell` may know a surfel: its tile exists.
  bool hasTile(const Cell& cell) const { return tiles_.find(cell) != nullptr; }

  /// Calls `visit(i, j, distance²)` for every cell (corner.x + i, corner.y + j) of a square of
  /// `side` cells that knows a surfel: the distance² from its middle to the surfel's mean, m². The
  /// square must lie in one tile.
  template <typename Visit>
  void forEachNearest(const Cell& corner, int side, Visit visit) const {
    const Tile* tile = tiles_.find(corner);
    if (tile == nullptr) return;
    for (int j = 0; j < side; ++j) {
      const std::uint32_t* ids = tile->nearest.data() + offsetInTile({corner.x, corner.y + j});
      const float y = (static_cast<float>(corner.y + j) + 0.5F) * resolution_;
      for (int i = 0; i < side; ++i) {
        if (ids[i] == kNone) continue;
        const Eigen::Vector2f& mean = surfels_[ids[i]].mean;
        const float ex = (static_cast<float>(corner.x + i) + 0.5F) * resolution_ - mean.x();
        const float ey = y - mean.y();
        visit(i, j, ex * ex + ey * ey);
      }
    }
  }

  void clear();
  float resolution() const { return resolution_; }
  std::size_t size() const { return surfels_.size() - free_.size(); }
  std::size_t memoryBytes() const {
    return tiles_.memoryBytes() + surfels_.capacity() * sizeof(Surfel);
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  static constexpr std::uint16_t kFar = 0xFFFFU;
  static constexpr float kDistanceSteps = 512.0F;  ///< of a squared distance, per cell²
  static_assert((kReachCells + 1) * (kReachCells + 1) * 512 < kFar, "squared distances fit");
  struct Tile {
    Tile() {
      nearest.fill(kNone);
      distance2.fill(kFar);
    }
    std::array<std::uint32_t, kTileCells> nearest;
    /// From the cell's center to its mean, in steps; 0 where the cell has a surfel itself.
    std::array<std::uint16_t, kTileCells> distance2;
    std::array<std::uint32_t, kTileSide> own{};  ///< one bit a cell: has a surfel itself
  };

  std::uint32_t idAt(const Cell& cell) const;
  void setOwn(const Cell& cell, bool own);
  void addHit(const OccupancyGrid::Changes::Hit& hit, const Eigen::Vector2f& tangent2, bool sparse);
  std::uint32_t create(const OccupancyGrid::Changes::Hit& hit);
  bool addMean(std::uint32_t id);
  void spread(std::uint32_t id);
  void remove(const Cell& cell);
  void orphan(std::uint32_t id);
  void adopt(const Cell& orphan);
  /// The mean of a surfel in cells, relative to its cell's lower left corner.
  Eigen::Vector2f meanInCell(const Surfel& surfel) const {
    return {surfel.mean.x() * inverse_resolution_ - static_cast<float>(surfel.cell.x),
            surfel.mean.y() * inverse_resolution_ - static_cast<float>(surfel.cell.y)};
  }
  void updateShape(std::uint32_t id);
  template <typename Visit>
  void forEachOwn(const Cell& center, int radius, Visit visit) const;

  float resolution_;
  float inverse_resolution_;
  TileMap<Tile> tiles_;
  std::vector<Surfel> surfels_;
  std::vector<std::uint32_t> free_;     ///< places in surfels_ that can be used again
  std::vector<std::uint32_t> changed_;  ///< surfels hit by the scan being inserted
  std::vector<std::uint32_t> moved_;    ///< those whose line has to follow
  std::vector<Cell> orphans_;           ///< of a removal: cells whose nearest surfel it was,
  struct Adopter {
    Eigen::Vector2f mean;  ///< in cells
    Cell cell;
    std::uint32_t id;
  };
  std::vector<Adopter> adopters_;  ///< and the surfels that can take its place
  bool full_ = false;              ///< the memory limit kept a part of the last update out
  std::uint32_t updates_ = 0;      ///< since the last clear
};

}  // namespace kestrel
