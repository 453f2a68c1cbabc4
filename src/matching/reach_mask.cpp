// SPDX-License-Identifier: BSD-3-Clause
#include "reach_mask.h"

#include <algorithm>

namespace kestrel {

ReachMask::ReachMask(const SearchGrid& grid, int margin, int before, int after) {
  const CellBox reach = grid.reach();
  const auto aligned = [&](int cell) { return ((cell >> kShift) - before) * kSide; };
  low_ = {aligned(reach.low.x), aligned(reach.low.y)};
  width_ = ((reach.high.x - low_.x) >> kShift) + 1 + after;
  height_ = ((reach.high.y - low_.y) >> kShift) + 1 + after;
  mask_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  const CellBox box{low_, reach.high};
  std::vector<PointCell> cells(static_cast<std::size_t>(grid.pointCount()));
  const int angles = grid.angularSteps() + margin;
  for (int k = -angles; k <= angles; ++k) {
    grid.rotate(k, 0, grid.pointCount(), box, cells.data());
    for (const PointCell& cell : cells) row(cell.y >> kShift)[cell.x >> kShift] = 1;
  }
  dilate(before, after);
}

void ReachMask::dilate(int before, int after) {
  const std::vector<std::uint8_t> source = mask_;
  std::vector<std::uint8_t> line(static_cast<std::size_t>(width_));
  for (int y = 0; y < height_; ++y) {
    const std::uint8_t* in = source.data() + static_cast<std::ptrdiff_t>(y) * width_;
    std::fill(line.begin(), line.end(), std::uint8_t{0});
    for (int x = 0; x < width_; ++x) {
      if (in[x] == 0) continue;
      std::fill(line.begin() + std::max(0, x - before),
                line.begin() + std::min(width_, x + after + 1), std::uint8_t{1});
    }
    for (int other = std::max(0, y - before); other < std::min(height_, y + after + 1); ++other) {
      std::uint8_t* out = row(other);
      for (const std::uint8_t marked : line) *out++ |= marked;
    }
  }
}

CellBox ReachMask::box() const {
  Cell low{width_, height_}, high{0, 0};
  forEach([&](int x, int y) {
    low = {std::min(low.x, x), std::min(low.y, y)};
    high = {std::max(high.x, x + 1), std::max(high.y, y + 1)};
  });
  if (high.x == 0) low = high;
  return {corner(low.x, low.y), corner(high.x, high.y)};
}

std::pair<int, int> ReachMask::span(int y) const {
  const std::uint8_t* begin = row(y);
  int first = 0, last = width_;
  while (first < last && begin[first] == 0) ++first;
  while (last > first && begin[last - 1] == 0) --last;
  return {first, last};
}

}  // namespace kestrel
