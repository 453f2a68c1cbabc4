// SPDX-License-Identifier: BSD-3-Clause
#include "window_sums.h"

#include <algorithm>
#include <array>

namespace kestrel {
namespace {

constexpr int kSumLanes = LikelihoodImage::kLanes;
/// Number of points that are summed in bytes before they are added to the total. With values of the
/// coarse levels, a row of windows of four points then takes little more time than that of one.
constexpr int kSummedTogether = 4;
static_assert(kSummedTogether * LikelihoodImage::kCoarseMax <= 0xFF,
              "the sum of four fits into a byte");
static_assert(kChunkPoints * LikelihoodImage::kMax <= 0xFFFF, "the sum of a chunk fits");
/// Maximum number of rows of windows at a time.
constexpr int kMaxRows = 32;

using ChunkSums = std::array<std::uint16_t, kMaxRows * kSumLanes>;

/// Sums `lanes` windows per row. The sum of four values fits into a `Four`. The loops over lanes
/// have a constant length, so that compilers use vector instructions on any processor.
template <int lanes, typename Four>
void addPoints(const LikelihoodImage& image, const Windows& windows, const PointCell* points,
               int count, ChunkSums& sums) {
  const std::ptrdiff_t step = static_cast<std::ptrdiff_t>(image.stride()) << windows.level;
  const auto at = [&](int n) {
    return image.at(windows.level, points[n].x + windows.dx, points[n].y + windows.dy);
  };
  int n = 0;
  for (; n + kSummedTogether <= count; n += kSummedTogether) {
    const std::uint8_t *a = at(n), *b = at(n + 1), *c = at(n + 2), *d = at(n + 3);
    std::uint16_t* sum = sums.data();
    for (int row = 0; row < windows.rows; ++row, sum += lanes) {
      for (int i = 0; i < lanes; ++i) {
        const auto four = static_cast<Four>(a[i] + b[i] + c[i] + d[i]);
        sum[i] = static_cast<std::uint16_t>(sum[i] + four);
      }
      a += step, b += step, c += step, d += step;
    }
  }
  for (; n < count; ++n) {
    const std::uint8_t* a = at(n);
    std::uint16_t* sum = sums.data();
    for (int row = 0; row < windows.rows; ++row, a += step, sum += lanes) {
      for (int i = 0; i < lanes; ++i) sum[i] = static_cast<std::uint16_t>(sum[i] + a[i]);
    }
  }
}

template <int lanes>
void addStrip(const LikelihoodImage& image, const Windows& strip, const PointCell* points,
              int count, int columns, int* sums) {
  ChunkSums chunk;
  std::fill_n(chunk.begin(), strip.rows * lanes, std::uint16_t{0});
  if (strip.level > 0) {
    addPoints<lanes, std::uint8_t>(image, strip, points, count, chunk);
  } else {
    addPoints<lanes, std::uint16_t>(image, strip, points, count, chunk);
  }
  const std::uint16_t* part = chunk.data();
  for (int row = 0; row < strip.rows; ++row, part += lanes, sums += columns) {
    for (int column = 0; column < strip.columns; ++column) sums[column] += part[column];
  }
}

}  // namespace

void addWindows(const LikelihoodImage& image, const Windows& windows, const PointCell* points,
                int count, int* sums) {
  Windows strip = windows;
  for (int row = 0; row < windows.rows; row += kMaxRows) {
    strip.rows = std::min(kMaxRows, windows.rows - row);
    strip.dy = windows.dy + row * (1 << windows.level);
    for (int column = 0; column < windows.columns; column += kSumLanes) {
      strip.columns = std::min(kSumLanes, windows.columns - column);
      strip.dx = windows.dx + column * (1 << windows.level);
      int* out = sums + row * windows.columns + column;
      if (strip.columns <= kSumLanes / 2) {
        addStrip<kSumLanes / 2>(image, strip, points, count, windows.columns, out);
      } else {
        addStrip<kSumLanes>(image, strip, points, count, windows.columns, out);
      }
    }
  }
}

}  // namespace kestrel
