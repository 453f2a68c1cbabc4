// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/map_replica.h"

#include <algorithm>

namespace kestrel {

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
    if (image.cells[i] == tile.cells[i]) continue;
    const int x = image.corner.x + static_cast<int>(i % kTileSide);
    const int y = image.corner.y + static_cast<int>(i / kTileSide);
    known_.extend(x, y);
    changed_.extend(x, y);
  }
  tile.cells = image.cells;
}

void MapReplica::clear() {
  tiles_.clear();
  known_ = changed_ = CellRectangle();
}

MapSnapshot MapReplica::snapshot() const {
  MapSnapshot map;
  map.resolution_m = resolution_m_;
  if (known_.empty()) return map;
  map.width = known_.x1 - known_.x0;
  map.height = known_.y1 - known_.y0;
  map.origin_x = static_cast<double>(known_.x0) * resolution_m_;
  map.origin_y = static_cast<double>(known_.y0) * resolution_m_;
  map.cells = valuesIn(known_);
  return map;
}

CellRectangle MapReplica::takeChanged() {
  const CellRectangle result = changed_;
  changed_ = CellRectangle();
  return result;
}

std::vector<std::int8_t> MapReplica::valuesIn(const CellRectangle& part) const {
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
