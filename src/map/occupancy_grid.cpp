// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/occupancy_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "log_odds.h"
#include "ray_run.h"

namespace kestrel {
namespace {

constexpr double kBytesPerMegabyte = 1e6;
/// Log odds of established free space (probability 0.18). A hit there may be a person or a moved
/// object. It counts 1 / kPasserByShare until several hits in a row confirm it. With a factor of 3
/// instead of 2, a tilting laser maps new objects too slowly.
constexpr std::int16_t kEstablishedFree = -1500;
constexpr int kPasserByShare = 2;

/// The bit of a cell in its row, and the row of a cell in its tile.
std::uint32_t bitOf(const Cell& cell) {
  return 1U << (static_cast<unsigned>(cell.x) & (kTileSide - 1U));
}
std::size_t rowOf(const Cell& cell) { return static_cast<unsigned>(cell.y) & (kTileSide - 1U); }

}  // namespace

OccupancyGrid::OccupancyGrid(const OccupancyGridConfig& config)
    : OccupancyGrid(config, std::make_shared<MemoryBudget>(static_cast<std::size_t>(
                                config.memory_limit_mb * kBytesPerMegabyte))) {}

OccupancyGrid::OccupancyGrid(const OccupancyGridConfig& config, SharedBudget budget)
    : resolution_m_(config.resolution_m),
      resolution_(static_cast<float>(config.resolution_m)),
      inverse_resolution_(1.0F / resolution_),
      hit_(logOddsOf(config.hit_probability)),
      miss_(logOddsOf(config.miss_probability)),
      min_(logOddsOf(config.min_probability)),
      max_(logOddsOf(config.max_probability)),
      probabilities_(probabilityTable()),
      tiles_(std::move(budget)) {}

void OccupancyGrid::clear() {
  tiles_.clear();
  touched_.clear();
  changed_tiles_.clear();
}

const OccupancyGrid::Changes& OccupancyGrid::insert(const PlanarScan& scan, const Pose2& map_T_base,
                                                    bool new_view) {
  return insert(scan, map_T_base, freeCells(scan, map_T_base), new_view);
}

FreeCells OccupancyGrid::freeCells(const PlanarScan& scan, const Pose2& map_T_base) const {
  return FreeCells(scan, map_T_base, inverse_resolution_, tiles_.limitBytes());
}

const OccupancyGrid::Changes& OccupancyGrid::insert(const PlanarScan& scan, const Pose2& map_T_base,
                                                    const FreeCells& free, bool new_view) {
  changes_.hits.clear();
  changes_.became_free.clear();
  changes_.full = false;
  markHits(scan, map_T_base);
  markMisses(free);
  markMissesUpToWalls(scan, map_T_base);
  removeMissesOfKnownHits(scan, map_T_base);
  const auto hit_in_free = static_cast<std::int16_t>(new_view ? hit_ : hit_ / kPasserByShare);
  for (Tile* tile : touched_) apply(*tile, hit_in_free);
  touched_.clear();
  return changes_;
}

OccupancyGrid::Tile* OccupancyGrid::touch(const Cell& cell) {
  Tile* tile = tiles_.obtain(cell);
  if (tile == nullptr) {
    changes_.full = true;
    return nullptr;
  }
  if (!tile->touched) {
    tile->touched = true;
    tile->corner = {cell.x & ~(kTileSide - 1), cell.y & ~(kTileSide - 1)};
    touched_.push_back(tile);
  }
  return tile;
}

void OccupancyGrid::markHits(const PlanarScan& scan, const Pose2& map_T_base) {
  const float c = static_cast<float>(std::cos(map_T_base.yaw));
  const float s = static_cast<float>(std::sin(map_T_base.yaw));
  const auto x = static_cast<float>(map_T_base.x), y = static_cast<float>(map_T_base.y);
  for (const PlanarRay& ray : scan.rays) {
    if (!ray.hit || ray.known) continue;
    const Eigen::Vector2f point(x + c * ray.end.x() - s * ray.end.y(),
                                y + s * ray.end.x() + c * ray.end.y());
    if (!(point.cwiseAbs().maxCoeff() * inverse_resolution_ < kMaxCellCoordinate)) continue;
    const Cell cell = cellAt(point);
    Tile* tile = touch(cell);
    if (tile == nullptr) continue;
    tile->hit[rowOf(cell)] |= bitOf(cell);
    changes_.hits.push_back({cell, point, tile->log_odds[offsetInTile(cell)] < 0});
  }
}

void OccupancyGrid::markMisses(const FreeCells& free) {
  changes_.full |= free.isFull();
  for (const FreeCells::Tile* cells : free.tiles()) {
    Tile* tile = touch(cells->corner);
    if (tile == nullptr) continue;
    for (std::size_t row = 0; row < kTileSide; ++row) tile->missed[row] |= cells->rows[row];
  }
}

/// Marks the cells that beams without a return pass, as missed or as presumably free.
void OccupancyGrid::markMissesUpToWalls(const PlanarScan& scan, const Pose2& map_T_base) {
  const BeamsInCells in_cells(map_T_base, inverse_resolution_);
  for (const PlanarRay& ray : scan.rays) {
    if (!ray.no_return && !ray.presumed) continue;
    forEachRun(in_cells(ray.origin), in_cells(ray.end), [&](const RayRun& run) {
      Tile* tile = touch(run.cell());
      if (tile == nullptr) return true;
      const int free = stepsToWall(*tile, run);
      mark(run, free, ray.presumed ? tile->presumed : tile->missed);
      return free == run.count;
    });
  }
}

/// Removes the misses of cells with hits that are already in the map.
void OccupancyGrid::removeMissesOfKnownHits(const PlanarScan& scan, const Pose2& map_T_base) {
  for (const PlanarRay& ray : scan.rays) {
    if (!ray.hit || !ray.known) continue;
    const Cell cell = cellAt((map_T_base * ray.end.cast<double>()).cast<float>());
    if (Tile* tile = tiles_.find(cell)) tile->missed[rowOf(cell)] &= ~bitOf(cell);
  }
}

/// Number of steps of a run before the first cell that is occupied or hit by this scan, or that
/// lies between two such cells, which touch at a corner.
int OccupancyGrid::stepsToWall(const Tile& tile, const RayRun& run) {
  const auto walls = [&tile](std::size_t row) { return tile.occupied[row] | tile.hit[row]; };
  // Most tiles on the way of a ray without a return have no wall.
  Row any = 0;
  for (std::size_t row = 0; row < kTileSide; ++row) any |= walls(row);
  if (any == 0U) return run.count;
  std::int64_t x = run.x, y = run.y;
  for (int k = 0; k < run.count; ++k, x += run.step_x, y += run.step_y) {
    const std::size_t row = static_cast<std::uint64_t>(y) >> 32 & (kTileSide - 1U);
    const Row bit = 1U << (static_cast<std::uint64_t>(x) >> 32 & (kTileSide - 1U));
    const Row here = walls(row);
    const Row above = row + 1 < kTileSide ? walls(row + 1) : 0U,
              below = row > 0 ? walls(row - 1) : 0U;
    const bool is_between = (here & (bit << 1U | bit >> 1U)) != 0U && ((above | below) & bit) != 0U;
    if ((here & bit) != 0U || is_between) return k;
  }
  return run.count;
}

void OccupancyGrid::apply(Tile& tile, std::int16_t hit_in_free) {
  applyMisses(tile);
  for (std::size_t row = 0; row < kTileSide; ++row) {
    for (Row bits = tile.hit[row]; bits != 0U; bits &= bits - 1U) {
      const auto column = static_cast<std::size_t>(__builtin_ctz(bits));
      std::int16_t& value = tile.log_odds[row * kTileSide + column];
      const bool is_presumed = value <= 0 && (tile.presumed[row] >> column & 1U) != 0U;
      const int weight = value < kEstablishedFree || is_presumed ? hit_in_free : hit_;
      const int sum = std::min<int>(value + weight, max_);
      value = static_cast<std::int16_t>(sum == 0 ? -1 : sum);
      if (value > 0) tile.occupied[row] |= 1U << column;
    }
  }
  tile.hit.fill(0U);
  tile.missed.fill(0U);
  tile.touched = false;
  if (!tile.changed) changed_tiles_.push_back(&tile);
  tile.changed = true;
}

void OccupancyGrid::applyMisses(Tile& tile) {
  for (std::size_t row = 0; row < kTileSide; ++row) {
    const Row missed = tile.missed[row] & ~tile.hit[row];
    if (missed == 0U) continue;
    addMisses(missed, miss_, min_, tile.log_odds.data() + row * kTileSide);
    for (Row bits = missed & tile.occupied[row]; bits != 0U; bits &= bits - 1U) {
      const int column = __builtin_ctz(bits);
      if (tile.log_odds[row * kTileSide + static_cast<std::size_t>(column)] > 0) continue;
      tile.occupied[row] &= ~(1U << column);
      changes_.became_free.push_back(
          {tile.corner.x + column, tile.corner.y + static_cast<int>(row)});
    }
  }
}

double OccupancyGrid::probability(const Cell& cell) const { return levelProbability(0, cell); }

InterpolatedValue OccupancyGrid::interpolate(int level, const Eigen::Vector2f& point) const {
  const float scale = inverse_resolution_ / static_cast<float>(1 << level);
  // A cell value is the value at the center of the cell.
  const Eigen::Vector2f p = (point * scale).array() - 0.5F;
  const Cell c{floorToInt(p.x()), floorToInt(p.y())};
  const float u = p.x() - static_cast<float>(c.x), v = p.y() - static_cast<float>(c.y);
  const auto value = [&](int dx, int dy) {
    return static_cast<float>(levelProbability(level, {c.x + dx, c.y + dy}));
  };
  const float m00 = value(0, 0), m10 = value(1, 0), m01 = value(0, 1), m11 = value(1, 1);
  InterpolatedValue result;
  result.value = v * (u * m11 + (1 - u) * m01) + (1 - v) * (u * m10 + (1 - u) * m00);  // eq. 4
  result.gradient.x() = scale * (v * (m11 - m01) + (1 - v) * (m10 - m00));             // eq. 5
  result.gradient.y() = scale * (u * (m11 - m10) + (1 - u) * (m01 - m00));             // eq. 6
  return result;
}

bool OccupancyGrid::takeChangedTiles(std::size_t max_tiles, std::vector<TileImage>& images) {
  const std::int8_t* percent = percentTable();
  for (; max_tiles > 0 && !changed_tiles_.empty(); --max_tiles) {
    Tile& tile = *changed_tiles_.back();
    changed_tiles_.pop_back();
    tile.changed = false;
    TileImage& image = images.emplace_back();
    image.corner = tile.corner;
    for (std::size_t i = 0; i < kTileCells; ++i) {
      const std::int16_t value = tile.log_odds[i];
      image.cells[i] = value == 0 ? MapSnapshot::kUnknown : percent[value];
    }
  }
  return !changed_tiles_.empty();
}

MapSnapshot OccupancyGrid::snapshot() const {
  MapSnapshot map;
  map.resolution_m = resolution_m_;
  int x0 = std::numeric_limits<int>::max(), y0 = x0, x1 = std::numeric_limits<int>::min(), y1 = x1;
  const auto forEachKnown = [this](auto visit) {
    tiles_.forEach([&](const Cell& corner, const Tile& tile) {
      for (std::size_t i = 0; i < kTileCells; ++i) {
        if (tile.log_odds[i] == 0) continue;
        visit(corner.x + static_cast<int>(i % kTileSide),
              corner.y + static_cast<int>(i / kTileSide), tile.log_odds[i]);
      }
    });
  };
  forEachKnown([&](int x, int y, std::int16_t) {
    x0 = std::min(x0, x), x1 = std::max(x1, x);
    y0 = std::min(y0, y), y1 = std::max(y1, y);
  });
  if (x1 < x0) return map;
  map.width = x1 - x0 + 1;
  map.height = y1 - y0 + 1;
  map.origin_x = static_cast<double>(x0) * map.resolution_m;
  map.origin_y = static_cast<double>(y0) * map.resolution_m;
  map.cells.assign(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height),
                   MapSnapshot::kUnknown);
  forEachKnown([&](int x, int y, std::int16_t log_odds) {
    map.cells[static_cast<std::size_t>(y - y0) * static_cast<std::size_t>(map.width) +
              static_cast<std::size_t>(x - x0)] =
        log_odds > 0 ? MapSnapshot::kOccupied : MapSnapshot::kFree;
  });
  return map;
}

}  // namespace kestrel
