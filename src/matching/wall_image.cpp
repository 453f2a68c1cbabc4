// SPDX-License-Identifier: BSD-3-Clause
#include "wall_image.h"

#include <algorithm>
#include <utility>

namespace kestrel {
namespace {

/// A point in the pixel next to a wall is worth this much less than one on the wall.
constexpr int kDrop = 25;
/// The last layer reaches this many pixels farther than layer 0, which reaches one.
constexpr int kReach = 1 << (WallImage::kLayers - 2);
constexpr int kPad = 2 * kReach;
/// Work per pixel for all layers, and per tile of the map.
constexpr std::int64_t kWorkPerPixel = 4, kWorkPerTile = 120;

using Bytes = std::vector<std::uint8_t>;

/// The maximum of every byte and of those `step` bytes before and after it, each reduced by `drop`.
void takeMaximum(const Bytes& in, std::ptrdiff_t step, int drop, Bytes& out) {
  const std::uint8_t* middle = in.data();
  const auto end = static_cast<std::ptrdiff_t>(in.size()) - step;
  const auto less = static_cast<std::uint8_t>(drop);
  for (std::ptrdiff_t i = step; i < end; ++i) {
    const std::uint8_t beside = std::max(middle[i - step], middle[i + step]);
    const auto reduced = static_cast<std::uint8_t>(std::max(beside, less) - less);
    out[static_cast<std::size_t>(i)] = std::max(middle[i], reduced);
  }
}

}  // namespace

int WallImage::pad() { return kPad; }

WallImage::WallImage(const SurfelField& surface, const CellBox& box, int shift)
    : shift_(shift),
      low_{(box.low.x >> shift) - kPad, (box.low.y >> shift) - kPad},
      width_((box.high.x >> shift) - low_.x + 1 + kPad),
      height_((box.high.y >> shift) - low_.y + 1 + kPad),
      layers_(kLayers) {
  const std::size_t size = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  for (Bytes& layer : layers_) layer.assign(size, 0);
  surface.forEachTile(box.low, box.high,
                      [this](const Cell& corner, const auto& rows) { mark(corner, rows); });
  soften();
  for (int n = 1; n < kLayers; ++n) spread(n, n == 1 ? 1 : 1 << (n - 2));
}

std::int64_t WallImage::workFor(const CellBox& box, int shift) {
  const std::int64_t width = ((box.high.x - box.low.x) >> shift) + 2 * kPad;
  const std::int64_t height = ((box.high.y - box.low.y) >> shift) + 2 * kPad;
  return width * height * (kWorkPerPixel + (kWorkPerTile >> (2 * (kTileShift - shift))));
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
      if (column < kPad || column >= width_ - kPad || line < kPad || line >= height_ - kPad)
        continue;
      layers_[0][static_cast<std::size_t>(line) * static_cast<std::size_t>(width_) +
                 static_cast<std::size_t>(column)] = kWall;
    }
  }
}

void WallImage::soften() {
  Bytes& buffer = layers_[1];
  takeMaximum(layers_[0], 1, kDrop, buffer);
  takeMaximum(buffer, width_, kDrop, layers_[0]);
}

/// Makes a layer from the one before it, which is extended by `pixels` in all directions.
void WallImage::spread(int layer, int pixels) {
  Bytes buffer(layers_[0].size(), 0);
  takeMaximum(layers_[static_cast<std::size_t>(layer - 1)], pixels, 0, buffer);
  takeMaximum(buffer, static_cast<std::ptrdiff_t>(pixels) * width_, 0,
              layers_[static_cast<std::size_t>(layer)]);
}

}  // namespace kestrel
