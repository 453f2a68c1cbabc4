// SPDX-License-Identifier: BSD-3-Clause
#include "bound_images.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/matching/unknown_score.h"
#include "round_up.h"

namespace kestrel {
namespace {

/// Standard deviation of the likelihood over the distance to a wall, m.
constexpr double kSigmaM = 0.1;
/// With more cells, the cells are made larger.
constexpr std::int64_t kMostCells = 4'000'000;
/// Cells around the map: a window of a tile that reaches farther out is unknown.
constexpr int kPad = BoundImages::kTileCells + 24;
/// A vehicle may stand so far from what it saw as free space: it does not see its own place, cells.
constexpr int kAroundBlocks = 2;
static_assert(BoundImages::kUnknown == static_cast<int>(kUnknownScore * BoundImages::kMax + 0.5));

/// Squares of this side lie in one tile of the surface.
constexpr int kSquare = 16;

int floorDiv(int value, int shift) { return value >> shift; }

}  // namespace

int BoundImages::imageFor(int side) {
  const auto* const found = std::lower_bound(kSides.begin(), kSides.end() - 1, side);
  return static_cast<int>(found - kSides.begin());
}

BoundImages::BoundImages(const Submap& map) {
  const MapSnapshot known = map.grid().snapshot();
  if (known.empty()) return;
  place(map, known);
  Bytes likelihood(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  markUnknown(known, likelihood);
  rasterize(map, likelihood);
  image_size_ = width_ * height_ + kTileBlocks;
  images_.reserve(kSides.size() * static_cast<std::size_t>(image_size_));
  for (const int side : kSides) addSorted(maxima(likelihood, side));
  markFree(known);
}

void BoundImages::place(const Submap& map, const MapSnapshot& known) {
  const auto resolution = static_cast<double>(map.grid().resolution());
  while ((static_cast<std::int64_t>(known.width) * known.height >> (2 * shift_)) > kMostCells)
    ++shift_;
  cell_m_ = resolution * (1 << shift_);
  const auto first = [&](double origin) {
    return (floorDiv(static_cast<int>(std::lround(origin / resolution)), shift_) - kPad) << shift_;
  };
  low_ = {first(known.origin_x), first(known.origin_y)};
  corner_ = Eigen::Vector2d(low_.x, low_.y) * resolution;
  width_ = roundUp((known.width >> shift_) + 2 * kPad + 2, kTileCells);
  height_ = roundUp((known.height >> shift_) + 2 * kPad + 2, kTileCells);
}

void BoundImages::markUnknown(const MapSnapshot& known, Bytes& likelihood) const {
  const int x0 = low_.x - static_cast<int>(std::lround(known.origin_x / known.resolution_m));
  const int y0 = low_.y - static_cast<int>(std::lround(known.origin_y / known.resolution_m));
  const auto isUnknown = [&](int x, int y) {
    const int column = x0 + x, row = y0 + y;
    return column < 0 || row < 0 || column >= known.width || row >= known.height ||
           known.at(column, row) == MapSnapshot::kUnknown;
  };
  for (int y = 0; y < height_ << shift_; ++y) {
    for (int x = 0; x < width_ << shift_; ++x) {
      if (!isUnknown(x, y)) continue;
      likelihood[static_cast<std::size_t>(y >> shift_) * static_cast<std::size_t>(width_) +
                 static_cast<std::size_t>(x >> shift_)] = kUnknown;
    }
  }
}

void BoundImages::rasterize(const Submap& map, Bytes& likelihood) const {
  const double factor = -0.5 / (kSigmaM * kSigmaM);
  const Cell first{low_.x & ~(kSquare - 1), low_.y & ~(kSquare - 1)};
  for (int y = first.y; y < low_.y + (height_ << shift_); y += kSquare) {
    for (int x = first.x; x < low_.x + (width_ << shift_); x += kSquare) {
      if (!map.surface().hasTile({x, y})) continue;
      map.surface().forEachNearest({x, y}, kSquare, [&](int i, int j, float distance2) {
        const int column = (x + i - low_.x) >> shift_, row = (y + j - low_.y) >> shift_;
        if (!contains(column, row)) return;
        // Rounded up: the values are bounds.
        const auto value = static_cast<std::uint8_t>(
            std::ceil(kMax * std::exp(factor * static_cast<double>(distance2)) - 0.5));
        std::uint8_t& cell =
            likelihood[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                       static_cast<std::size_t>(column)];
        cell = std::max(cell, value);
      });
    }
  }
}

void BoundImages::markFree(const MapSnapshot& known) {
  const int columns = width_ / 4, rows = height_ / 4;
  Bytes seen(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  const int x0 = static_cast<int>(std::lround(known.origin_x / known.resolution_m)) - low_.x;
  const int y0 = static_cast<int>(std::lround(known.origin_y / known.resolution_m)) - low_.y;
  for (int row = 0; row < known.height; ++row) {
    for (int column = 0; column < known.width; ++column) {
      if (known.at(column, row) != MapSnapshot::kFree) continue;
      const int x = ((x0 + column) >> shift_) / 4, y = ((y0 + row) >> shift_) / 4;
      seen[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(x)] = 1;
    }
  }
  free_.assign(seen.size(), 0);
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      if (seen[static_cast<std::size_t>(y * columns + x)] == 0) continue;
      for (int dy = -kAroundBlocks; dy <= kAroundBlocks; ++dy) {
        for (int dx = -kAroundBlocks; dx <= kAroundBlocks; ++dx)
          free_[static_cast<std::size_t>((y + dy) * columns + x + dx)] = 1;
      }
    }
  }
  for (int y = 0; y < height_; y += kTileCells) {
    for (int x = 0; x < width_; x += kTileCells) {
      bool any = false;
      for (int j = 0; j < kTileCells && !any; j += 4) {
        for (int i = 0; i < kTileCells && !any; i += 4) any = isFree(x + i, y + j);
      }
      if (any) tiles_.push_back({x, y});
    }
  }
}

/// The maximum of every cell over [x, x + side) and the same in y.
BoundImages::Bytes BoundImages::maxima(const Bytes& likelihood, int side) const {
  const auto along = [side](const Bytes& in, std::ptrdiff_t step) {
    Bytes out = in;
    const auto size = static_cast<std::ptrdiff_t>(in.size());
    for (std::ptrdiff_t d = 1; d < side; ++d) {
      const std::uint8_t* source = in.data() + d * step;
      std::uint8_t* result = out.data();
      for (std::ptrdiff_t i = 0; i < size - d * step; ++i)
        result[i] = std::max(result[i], source[i]);
    }
    return out;
  };
  return along(along(likelihood, 1), width_);
}

/// Adds the image with the cells of every row in their order.
void BoundImages::addSorted(const Bytes& image) {
  const std::size_t first = images_.size();
  images_.resize(first + static_cast<std::size_t>(image_size_), 0);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      images_[first + offset(x, y)] =
          image[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                static_cast<std::size_t>(x)];
    }
  }
}

std::size_t BoundImages::memoryBytes() const {
  return images_.capacity() + free_.capacity() + tiles_.capacity() * sizeof(Tile);
}

}  // namespace kestrel
