// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/map_replica.h"

#include <algorithm>
#include <utility>

namespace kestrel {
namespace {

constexpr std::int8_t kEvenPercent = 50;

std::int8_t stateOf(std::int8_t percent) {
  if (percent < 0) return MapSnapshot::kUnknown;
  return percent > kEvenPercent ? MapSnapshot::kOccupied : MapSnapshot::kFree;
}

}  // namespace

void CellRectangle::extend(int x, int y) {
  if (empty()) {
    *this = {x, y, x + 1, y + 1};
    return;
  }
  x0 = std::min(x0, x), x1 = std::max(x1, x + 1);
  y0 = std::min(y0, y), y1 = std::max(y1, y + 1);
}

void MapReplica::update(const TileImage& image) {
  Tile& tile = *tiles_.obtain(image.corner);
  for (std::size_t i = 0; i < kTileCells; ++i) {
    if (stateOf(image.cells[i]) == stateOf(tile.cells[i])) continue;
    const int x = image.corner.x + static_cast<int>(i % kTileSide);
    const int y = image.corner.y + static_cast<int>(i / kTileSide);
    known_.extend(x, y);
    if (!before_) changed_.extend(x, y);
  }
  tile.cells = image.cells;
}

void MapReplica::beginMap() {
  if (!before_) before_ = std::move(tiles_);
  tiles_ = Tiles(SIZE_MAX);
  known_ = CellRectangle();
}

void MapReplica::endMap() {
  if (!before_) return;
  const Tile unknown;
  before_->forEach([&](const Cell& corner, const Tile& old) {
    const Tile* tile = tiles_.find(corner);
    noteDifferences(corner, old, tile != nullptr ? *tile : unknown);
  });
  tiles_.forEach([&](const Cell& corner, const Tile& tile) {
    if (before_->find(corner) == nullptr) noteDifferences(corner, unknown, tile);
  });
  before_.reset();
}

void MapReplica::noteDifferences(const Cell& corner, const Tile& a, const Tile& b) {
  for (std::size_t i = 0; i < kTileCells; ++i) {
    if (stateOf(a.cells[i]) == stateOf(b.cells[i])) continue;
    changed_.extend(corner.x + static_cast<int>(i % kTileSide),
                    corner.y + static_cast<int>(i / kTileSide));
  }
}

MapSnapshot MapReplica::snapshot() const { return mapOf(valuesIn(known_)); }
MapSnapshot MapReplica::probabilities() const { return mapOf(percentIn(known_)); }

MapSnapshot MapReplica::mapOf(std::vector<std::int8_t> cells) const {
  MapSnapshot map;
  map.resolution_m = resolution_m_;
  if (known_.empty()) return map;
  map.width = known_.x1 - known_.x0;
  map.height = known_.y1 - known_.y0;
  map.origin_x = static_cast<double>(known_.x0) * resolution_m_;
  map.origin_y = static_cast<double>(known_.y0) * resolution_m_;
  map.cells = std::move(cells);
  return map;
}

CellRectangle MapReplica::takeChanged() {
  const CellRectangle result = changed_;
  changed_ = CellRectangle();
  return result;
}

std::vector<std::int8_t> MapReplica::valuesIn(const CellRectangle& part) const {
  std::vector<std::int8_t> values = percentIn(part);
  std::transform(values.begin(), values.end(), values.begin(), stateOf);
  return values;
}

std::vector<std::int8_t> MapReplica::percentIn(const CellRectangle& part) const {
  if (part.empty()) return {};
  const auto width = static_cast<std::size_t>(part.x1 - part.x0);
  std::vector<std::int8_t> values(width * static_cast<std::size_t>(part.y1 - part.y0),
                                  MapSnapshot::kUnknown);
  for (int y = part.y0; y < part.y1; ++y) {
    std::int8_t* row = values.data() + width * static_cast<std::size_t>(y - part.y0);
    for (int x = part.x0; x < part.x1;) {
      const int end = std::min(part.x1, (x | (kTileSide - 1)) + 1);
      if (const Tile* tile = tiles_.find({x, y})) {
        const std::int8_t* cells = tile->cells.data() + offsetInTile({x, y});
        std::copy(cells, cells + (end - x), row + (x - part.x0));
      }
      x = end;
    }
  }
  return values;
}

}  // namespace kestrel
