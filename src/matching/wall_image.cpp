// SPDX-License-Identifier: BSD-3-Clause
#include "wall_image.h"

#include <algorithm>
#include <array>
#include <utility>

namespace kestrel {
namespace {

/// The last layer reaches this many pixels farther than layer 0, which reaches one.
constexpr int kReach = 1 << (WallImage::kMostLayers - 2);
constexpr int kMargin = 2 * kReach;
/// Work per pixel of each layer, and per tile of the map.
constexpr std::int64_t kWorkPerPixel = 2, kWorkPerWallTile = 100;

/// Pixels of a row that are computed at once.
constexpr int kBlock = 16;

/// Zeroed row by row: a row is short enough for plain vector stores.
std::unique_ptr<std::uint8_t[]> newPixels(int width, int height) {
  const std::ptrdiff_t size = static_cast<std::ptrdiff_t>(width) * height;
  std::unique_ptr<std::uint8_t[]> pixels(new std::uint8_t[static_cast<std::size_t>(size)]);
  for (std::ptrdiff_t row = 0; row < size; row += width)
    std::fill_n(pixels.get() + row, width, std::uint8_t{0});
  return pixels;
}

/// The maximum of every pixel and of those `step` before and after it, which are divided by
/// 2^shift; for `count` pixels, rounded up to whole blocks. A block is a local variable: the
/// compiler knows that it overlaps with nothing, and uses vector instructions.
template <int shift>
void takeMaximum(const std::uint8_t* in, int count, std::ptrdiff_t step, std::uint8_t* out) {
  const std::uint8_t *before = in - step, *after = in + step;
  std::array<std::uint8_t, kBlock> block;
  for (std::ptrdiff_t i = 0; i < count; i += kBlock) {
    for (std::size_t k = 0; k < kBlock; ++k) {
      const std::uint8_t beside = std::max(before[k], after[k]);
      block[k] = std::max(in[k], static_cast<std::uint8_t>(beside >> shift));
    }
    std::copy(block.begin(), block.end(), out + i);
    before += kBlock, in += kBlock, after += kBlock;
  }
}

}  // namespace

WallImage::WallImage(const SurfelField& surface, const CellBox& box, int shift, int layers)
    : box_(box),
      shift_(shift),
      low_{(box.low.x >> shift) - kMargin, (box.low.y >> shift) - kMargin},
      width_((box.high.x >> shift) - low_.x + 1 + kMargin),
      height_((box.high.y >> shift) - low_.y + 1 + kMargin),
      spans_(static_cast<std::size_t>(height_), Span{width_, 0}),
      layers_(static_cast<std::size_t>(layers)) {
  for (auto& layer : layers_) layer = newPixels(width_, height_);
  surface.forEachTile(box.low, box.high,
                      [this](const Cell& corner, const auto& rows) { mark(corner, rows); });
  const auto buffer = newPixels(width_, height_);
  extend<1>(layers_[0].get(), 1, buffer.get(), layers_[0].get());
  for (int n = 1; n < layers; ++n)
    extend<0>(layer(n - 1), n == 1 ? 1 : 1 << (n - 2), buffer.get(),
              layers_[static_cast<std::size_t>(n)].get());
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
      layers_[0][static_cast<std::size_t>(placeOf(column, line))] = kWall;
      Span& span = spans_[static_cast<std::size_t>(line)];
      span = {std::min(span.first, column), std::max(span.last, column + 1)};
    }
  }
}

/// Extends the walls by `pixels` in all directions, divided by 2^shift. Only the spans are
/// computed: outside of them everything is zero. `buffer` may have the result of an earlier call.
template <int shift>
void WallImage::extend(const std::uint8_t* in, int pixels, std::uint8_t* buffer,
                       std::uint8_t* out) {
  std::vector<Span> beside = spans_;
  for (int row = 0; row < height_; ++row) {
    Span& span = beside[static_cast<std::size_t>(row)];
    if (span.first >= span.last) continue;
    span = {span.first - pixels, span.last + pixels};
    const std::ptrdiff_t at = placeOf(span.first, row);
    takeMaximum<shift>(in + at, span.last - span.first, pixels, buffer + at);
  }
  for (int row = pixels; row < height_ - pixels; ++row) {
    Span& span = spans_[static_cast<std::size_t>(row)];
    for (const int other : {row - pixels, row, row + pixels}) {
      const Span& part = beside[static_cast<std::size_t>(other)];
      span = {std::min(span.first, part.first), std::max(span.last, part.last)};
    }
    if (span.first >= span.last) continue;
    const std::ptrdiff_t at = placeOf(span.first, row);
    takeMaximum<shift>(buffer + at, span.last - span.first, placeOf(0, pixels), out + at);
  }
}

}  // namespace kestrel
