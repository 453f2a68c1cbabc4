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

/// Weight of distances along a wall. It is not zero, so that points do not slide past the end of
/// the wall.
constexpr float kAlongWeight = 0.05F;

/// Elements (11, 12, 22) of A = n n' + kAlongWeight t t' for a wall with normal n and direction t.
/// `t2`: (cos, sin) of twice the angle of t.
inline Eigen::Vector3f lineShape(const Eigen::Vector2f& t2) {
  const float nx2 = 0.5F * (1.0F - t2.x()), ny2 = 1.0F - nx2, nxy = -0.5F * t2.y();
  return {nx2 + kAlongWeight * ny2, nxy * (1.0F - kAlongWeight), ny2 + kAlongWeight * nx2};
}

/// The surface in one occupied cell: the mean of its hits and the direction of the wall.
struct Surfel {
  Eigen::Vector2f mean;     ///< mean of the end points in the cell, m
  Eigen::Vector2f on_wall;  ///< the mean, moved across the wall to the hits in neighboring cells, m
  float a11, a12, a22;      ///< information matrix A: distance² = e' A e for e = point - on_wall
  Cell cell;
  float count = 0.0F;  ///< number of hits in the mean, limited so that the mean can follow changes
  /// Direction of the wall from neighboring hits in the scans: sum of (cos, sin) of twice its
  /// angle, so that opposite directions are equal. Zero if no scan has neighboring hits on a wall.
  Eigen::Vector2f tangent2 = Eigen::Vector2f::Zero();
  /// The same from neighbors that are far apart. The match does not use this direction: without
  /// another one the surfel stays a point, which constrains the pose in all directions. It is used
  /// to decide whether the direction along the wall is observable.
  Eigen::Vector2f sparse2 = Eigen::Vector2f::Zero();
  /// Of the current scan: number of hits, and sum of their differences to the mean.
  float new_hits = 0.0F;
  Eigen::Vector2f new_sum = Eigen::Vector2f::Zero();
  /// Number of the scan that created the surfel.
  std::uint32_t birth = 0;
  /// It appeared where free space and no wall was known: a person, a moved object, or the floor
  /// that a tilted laser sees. It says nothing about the motion along a corridor.
  bool appeared = false;
};

/// Whether the wall direction is unknown. Such a surfel constrains the pose in all directions.
inline bool isPoint(const Surfel& surfel) {
  // Between the trace of a line and that of a point, which is 2.
  constexpr float kPointTrace = 1.5F;
  return surfel.a11 + surfel.a22 >= kPointTrace;
}

/// The normal n of a surfel on a wall, whose A is n n' + kAlongWeight t t'.
inline Eigen::Vector2f normalOf(const Surfel& surfel) {
  const float nx2 = (surfel.a11 - kAlongWeight) / (1.0F - kAlongWeight);
  const float nx = std::sqrt(std::clamp(nx2, 0.0F, 1.0F));
  return {nx, std::copysign(std::sqrt(1.0F - nx * nx), surfel.a12)};
}

/// Elements (11, 12, 22) of the information matrix for observability: A, or for a point with
/// distant neighbors the matrix of the line through them.
inline Eigen::Vector3f constraintOf(const Surfel& surfel) {
  const float length = isPoint(surfel) ? surfel.sparse2.norm() : 0.0F;
  if (length > 0.0F) return lineShape(surfel.sparse2 / length);
  return {surfel.a11, surfel.a12, surfel.a22};
}

/// Smooth surface for matching, derived from an OccupancyGrid: the nearest surfel for every cell.
///
/// There is one surfel for each occupied cell of the grid. A point finds its surfel with one
/// look-up, up to kReachCells away. The distance to the wall through the surfel has sub-cell
/// accuracy and an exact gradient.
class SurfelField {
 public:
  /// Radius around a surfel, in cells, in which cells refer to it: 0.45 m at 5 cm.
  static constexpr int kReachCells = 9;

  /// The budget may be shared with other parts of the map.
  SurfelField(float resolution_m, const SharedBudget& budget);
  SurfelField(float resolution_m, std::size_t limit_bytes)
      : SurfelField(resolution_m, std::make_shared<MemoryBudget>(limit_bytes)) {}

  /// Applies the changes of the last insertion into `grid`, of the scan with this number. Returns
  /// false if the memory limit kept a part out.
  bool update(const OccupancyGrid& grid, const OccupancyGrid::Changes& changes,
              std::uint32_t number = 0);

  /// The surfel nearest to the cell of `point` (map frame, m), or nullptr if none is within reach.
  const Surfel* nearest(const Eigen::Vector2f& point) const {
    return nearestTo(Cell{floorToInt(point.x() * inverse_resolution_),
                          floorToInt(point.y() * inverse_resolution_)});
  }
  /// The surfel nearest to `cell`, or nullptr.
  const Surfel* nearestTo(const Cell& cell) const {
    const Tile* tile = tiles_.find(cell);
    if (tile == nullptr) return nullptr;
    const std::uint32_t id = tile->nearest[offsetInTile(cell)];
    return id == kNone ? nullptr : &surfels_[id];
  }
  /// The surfels nearest to four cells, with most of the work done once for all of them. Where none
  /// is within reach, a surfel of zeros.
  std::array<const Surfel*, 4> nearestOrZeros(const FourInts& x, const FourInts& y) const {
    FourInts slots;
    if (!tiles_.findSlots(x, y, slots)) {
      const auto one = [&](int i) {
        const Surfel* surfel = nearestTo(Cell{x[i], y[i]});
        return surfel != nullptr ? surfel : &zeros();
      };
      return {one(0), one(1), one(2), one(3)};
    }
    const auto slot = arrayOf(slots), offset = arrayOf(offsetsInTile(x, y));
    const Surfel *surfels = surfels_.data(), *none = &zeros();
    const auto one = [&](std::size_t i) {
      const Tile* tile = tiles_.inSlot(static_cast<std::uint32_t>(slot[i]));
      return tile == nullptr ? none
                             : surfels + tile->nearest[static_cast<std::uint32_t>(offset[i])];
    };
    return {one(0), one(1), one(2), one(3)};
  }

  /// All surfels with their mean in `area` (map frame, m), in the order of the tiles.
  std::vector<Surfel> surfelsIn(const Eigen::AlignedBox2f& area) const;

  /// Whether the tile of `cell` exists. If not, no cell in it has a nearest surfel.
  bool hasTile(const Cell& cell) const { return tiles_.find(cell) != nullptr; }

  /// One bit for each cell of a tile that has a surfel itself, row by row.
  using OccupiedRows = std::array<std::uint32_t, kTileSide>;

  /// Calls `visit(lower_left_cell, rows)` for every tile with a cell in [low, high].
  template <typename Visit>
  void forEachTile(const Cell& low, const Cell& high, Visit visit) const {
    for (int y = low.y & ~(kTileSide - 1); y <= high.y; y += kTileSide) {
      for (int x = low.x & ~(kTileSide - 1); x <= high.x; x += kTileSide) {
        if (const Tile* tile = tiles_.find({x, y})) visit(Cell{x, y}, tile->own);
      }
    }
  }

  /// Calls `visit(i, j, distance²)` for every cell (corner.x + i, corner.y + j) in a square of
  /// `side` cells that has a nearest surfel. distance²: from the center of the cell to the mean of
  /// the surfel, m². The square must lie in one tile.
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
  float cellsPerMeter() const { return inverse_resolution_; }
  /// The surfel of zeros of nearestOrZeros.
  static const Surfel& zeros() { return kZeros; }
  std::size_t size() const { return surfels_.empty() ? 0 : surfels_.size() - free_.size() - 1; }
  std::size_t memoryBytes() const {
    return tiles_.memoryBytes() + surfels_.capacity() * sizeof(Surfel);
  }

 private:
  static const Surfel kZeros;
  /// The first surfel is one of zeros, so that a look-up need not ask whether there is one.
  static constexpr std::uint32_t kNone = 0;
  static constexpr std::uint16_t kFar = 0xFFFFU;
  /// Resolution of squared distances: steps per cell².
  static constexpr float kDistanceSteps = 512.0F;
  static_assert((kReachCells + 1) * (kReachCells + 1) * 512 < kFar,
                "squared distances fit into 16 bits");
  struct Tile {
    Tile() {
      nearest.fill(kNone);
      distance2.fill(kFar);
    }
    std::array<std::uint32_t, kTileCells> nearest;
    /// From the center of the cell to the mean of the nearest surfel, in steps; 0 if the cell has a
    /// surfel itself.
    std::array<std::uint16_t, kTileCells> distance2;
    OccupiedRows own{};
  };

  std::uint32_t idAt(const Cell& cell) const;
  bool isAtWall(const Tile& tile, std::size_t offset) const;
  bool hasRoom();
  void setOwn(const Cell& cell, bool own);
  void addHit(const OccupancyGrid::Changes::Hit& hit, const Eigen::Vector2f& tangent2, bool sparse);
  std::uint32_t create(const OccupancyGrid::Changes::Hit& hit);
  bool addMean(std::uint32_t id);
  void spread(std::uint32_t id);
  void spreadIn(Cell corner, std::uint32_t id);
  void remove(const Cell& cell);
  void detach(std::uint32_t id);
  void attachToNearest(const Cell& cell);
  /// The mean of a surfel in cells, relative to the lower left corner of its cell.
  Eigen::Vector2f meanInCell(const Surfel& surfel) const {
    return {surfel.mean.x() * inverse_resolution_ - static_cast<float>(surfel.cell.x),
            surfel.mean.y() * inverse_resolution_ - static_cast<float>(surfel.cell.y)};
  }
  void updateShape(std::uint32_t id);
  void align(std::uint32_t id);
  template <typename Visit>
  void forEachOwn(const Cell& center, int radius, Visit visit) const;

  float resolution_;
  float inverse_resolution_;
  SharedBudget budget_;
  TileMap<Tile> tiles_;
  std::vector<Surfel> surfels_;
  std::vector<std::uint32_t> free_;     ///< unused places in surfels_
  std::vector<std::uint32_t> changed_;  ///< surfels with hits of the current scan
  std::vector<std::uint32_t> moved_;    ///< changed surfels whose line has to be updated
  std::vector<Cell> detached_;          ///< cells whose nearest surfel is being removed
  struct Candidate {
    Eigen::Vector2f mean;  ///< in cells
    Cell cell;
    std::uint32_t id;
  };
  std::vector<Candidate> candidates_;  ///< surfels that may be the nearest for these cells now
  bool full_ = false;  ///< a part of the last update was left out because of the memory limit
  std::uint32_t number_ = 0;  ///< of the scan of the last update
};

}  // namespace kestrel
