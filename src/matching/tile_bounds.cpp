// SPDX-License-Identifier: BSD-3-Clause
#include "tile_bounds.h"

#include <cstddef>

namespace kestrel {
namespace {

constexpr std::size_t kTogether = 4;
static_assert(kTogether * BoundImages::kMax <= 0xFF, "the sum of four fits into a byte");

}  // namespace

TileSums boundsIn(const BoundImages& images, const std::vector<RotatedPoint>& turned,
                  const BoundImages::Tile& tile) {
  constexpr int kSide = BoundImages::kTileBlocks, kCells = BoundImages::kTileCells;
  TileSums sums{};
  std::vector<const std::uint8_t*> windows;
  windows.reserve(turned.size());
  for (const RotatedPoint& p : turned) {
    const int x = tile.x + p.x, y = tile.y + p.y;
    if (images.contains(x, y) && images.contains(x + kCells - 1, y + kCells - 1))
      windows.push_back(images.at(p.image, x, y));
  }
  const std::size_t outside = turned.size() - windows.size();
  sums.fill(static_cast<std::uint16_t>(outside * BoundImages::kUnknown));
  const std::ptrdiff_t step = 4 * static_cast<std::ptrdiff_t>(images.width());
  std::size_t n = 0;
  for (; n + kTogether <= windows.size(); n += kTogether) {
    const std::uint8_t *a = windows[n], *b = windows[n + 1], *c = windows[n + 2],
                       *d = windows[n + 3];
    std::uint16_t* sum = sums.data();
    for (int row = 0; row < kSide; ++row, sum += kSide) {
      for (int i = 0; i < kSide; ++i) {
        const auto four = static_cast<std::uint8_t>(a[i] + b[i] + c[i] + d[i]);
        sum[i] = static_cast<std::uint16_t>(sum[i] + four);
      }
      a += step, b += step, c += step, d += step;
    }
  }
  for (; n < windows.size(); ++n) {
    const std::uint8_t* a = windows[n];
    std::uint16_t* sum = sums.data();
    for (int row = 0; row < kSide; ++row, sum += kSide, a += step) {
      for (int i = 0; i < kSide; ++i) sum[i] = static_cast<std::uint16_t>(sum[i] + a[i]);
    }
  }
  return sums;
}

}  // namespace kestrel
