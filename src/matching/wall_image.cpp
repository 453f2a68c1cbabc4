// SPDX-License-Identifier: BSD-3-Clause
#include "wall_image.h"

#include <algorithm>
#include <utility>

namespace kestrel {
namespace {

/// The last layer reaches this many pixels farther than layer 0, which reaches one.
constexpr int kReach = 1 << (WallImage::kMostLayers - 2);
constexpr int kMargin = 2 * kReach;
/// Work per pixel of each layer, and per tile of the map.
constexpr std::int64_t kWorkPerPixel = 2, kWorkPerWallTile = 100;

/// Not zeroed: all bytes are written by takeMaximum.
std::unique_ptr<std::uint8_t[]> newPixels(std::ptrdiff_t size) {
  return std::unique_ptr<std::uint8_t[]>(new std::uint8_t[static_cast<std::size_t>(size)]);
}

/// The maximum of every byte and of those `step` bytes before and after it, which are divided by
/// 2^shift; zero where there is no byte before or after. Plain pointers and a known shift, so that
/// the compiler uses vector instructions.
template <int shift>
void takeMaximum(const std::uint8_t* in, std::ptrdiff_t size, std::ptrdiff_t step,
                 std::uint8_t* out) {
  const std::ptrdiff_t count = size - 2 * step;
  const std::uint8_t *before = in, *middle = before + step, *after = middle + step;
  std::uint8_t* result = out + step;
  std::fill(out, result, std::uint8_t{0});
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::uint8_t beside = std::max(before[i], after[i]);
    result[i] = std::max(middle[i], static_cast<std::uint8_t>(beside >> shift));
  }
  std::fill(result + count, out + size, std::uint8_t{0});
}

}  // namespace

WallImage::WallImage(const SurfelField& surface, const CellBox& box, int shift, int layers)
    : box_(box),
      shift_(shift),
      low_{(box.low.x >> shift) - kMargin, (box.low.y >> shift) - kMargin},
      width_((box.high.x >> shift) - low_.x + 1 + kMargin),
      height_((box.high.y >> shift) - low_.y + 1 + kMargin),
      layers_(static_cast<std::size_t>(layers)) {
  for (auto& layer : layers_) layer = newPixels(size());
  std::fill_n(layers_[0].get(), size(), std::uint8_t{0});
  surface.forEachTile(box.low, box.high,
                      [this](const Cell& corner, const auto& rows) { mark(corner, rows); });
  const auto buffer = newPixels(size());
  soften(buffer.get());
  for (int n = 1; n < layers; ++n) spread(n, n == 1 ? 1 : 1 << (n - 2), buffer.get());
}

bool WallImage::covers(const CellBox& box, int shift, int layers) const {
  return shift == shift_ && static_cast<std::size_t>(layers) <= layers_.size() &&
         box.low.x >= box_.low.x && box.low.y >= box_.low.y && box.high.x <= box_.high.x &&
         box.high.y <= box_.high.y;
}

std::int64_t WallImage::workFor(const CellBox& box, int shift, int layers) {
  const std::int64_t width = ((box.high.x - box.low.x) >> shift) + 2 * kMargin;
  const std::int64_t height = ((box.high.y - box.low.y) >> shift) + 2 * kMargin;
  return width * height *
         (kWorkPerPixel * layers + (kWorkPerWallTile >> (2 * (kTileShift - shift))));
}

void WallImage::mark(const Cell& tile_corner, const SurfelField::OccupiedRows& rows) {
  const int side = 1 << shift_;
  const std::uint32_t mask = side < kTileSide ? (1U << side) - 1U : ~0U;
  for (int y = 0; y < kTileSide; y += side) {
    std::uint32_t any = 0;
    for (int row = y; row < y + side; ++row) any |= rows[static_cast<std::size_t>(row)];
    while (any != 0U) {
      const int x = __builtin_ctz(any) & ~(side - 1);
      any &= ~(mask << x);
      const int column = ((tile_corner.x + x) >> shift_) - low_.x;
      const int line = ((tile_corner.y + y) >> shift_) - low_.y;
      // A tile at the border may reach out of the image.
      if (column < kMargin || column >= width_ - kMargin || line < kMargin ||
          line >= height_ - kMargin)
        continue;
      layers_[0][static_cast<std::size_t>(line) * static_cast<std::size_t>(width_) +
                 static_cast<std::size_t>(column)] = kWall;
    }
  }
}

void WallImage::soften(std::uint8_t* buffer) {
  takeMaximum<1>(layers_[0].get(), size(), 1, buffer);
  takeMaximum<1>(buffer, size(), width_, layers_[0].get());
}

/// Makes a layer from the one before it, which is extended by `pixels` in all directions.
void WallImage::spread(int layer, int pixels, std::uint8_t* buffer) {
  const auto n = static_cast<std::size_t>(layer);
  takeMaximum<0>(layers_[n - 1].get(), size(), pixels, buffer);
  takeMaximum<0>(buffer, size(), static_cast<std::ptrdiff_t>(pixels) * width_, layers_[n].get());
}

}  // namespace kestrel
