// SPDX-License-Identifier: BSD-3-Clause
#include "likelihood_image.h"

#include <algorithm>
#include <cmath>

#include "round_up.h"

namespace kestrel {
namespace {

/// Resolution of the table: steps per cell² of squared distance.
constexpr int kTableSteps = 32;
/// Maximum distance of a cell to its surfel: kReachCells, and up to two cells that a mean can move.
constexpr int kFarthest = SurfelField::kReachCells + 2;

/// exp(-d² / (2 sigma²)) in steps of 1/255, indexed by squared distance. The last entry, 0, is for
/// all larger distances.
std::vector<std::uint8_t> likelihoodTable(double sigma_cells) {
  const double ratio = std::exp(-0.5 / (sigma_cells * sigma_cells * kTableSteps));
  std::vector<std::uint8_t> table;
  double likelihood = LikelihoodImage::kMax;
  for (int i = 0; i < kTableSteps * kFarthest * kFarthest && likelihood >= 0.5; ++i) {
    table.push_back(static_cast<std::uint8_t>(likelihood + 0.5));
    likelihood *= ratio;
  }
  table.push_back(0);
  return table;
}

/// Converts a value of level 0 to a coarser level, rounded up.
std::uint8_t coarse(std::uint8_t value) {
  return static_cast<std::uint8_t>(std::min((value + 3) >> 2, LikelihoodImage::kCoarseMax));
}
static_assert(4 * LikelihoodImage::kCoarseMax < LikelihoodImage::kMax, "v / 4 / 63 >= v / 255");

}  // namespace

LikelihoodImage::LikelihoodImage(const SurfelField& surface, const SearchGrid& grid, int margin,
                                 double sigma_m, int levels)
    : levels_(static_cast<std::size_t>(levels)) {
  const int linear = grid.linearSteps() + margin, widest = 1 << (levels - 1);
  ReachMask reached(grid, margin, ReachMask::blocksFor(linear),
                    ReachMask::blocksFor(linear + widest));
  reached.filter([&](const Cell& corner) { return surface.hasTile(corner); });
  place(reached.box(), linear);
  rasterize(surface, reached, sigma_m);
  reached.dilate(ReachMask::blocksFor(widest),
                 0);  // first cells of the windows that can reach these cells
  for (int level = 1; level < levels; ++level) buildLevel(level, reached);
}

void LikelihoodImage::place(const CellBox& reached, int linear_steps) {
  // All windows of a point at the border are empty.
  const int unit = std::max(1 << (levels() - 1), ReachMask::kSide);
  pad_ = roundUp(linear_steps + unit, unit);
  box_.low = {reached.low.x - pad_, reached.low.y - pad_};
  box_.high = {reached.high.x + pad_ + 1, reached.high.y + pad_ + 1};
  stride_ = roundUp(box_.high.x - box_.low.x + 2 * pad_, unit);
  const int rows = box_.high.y - box_.low.y + 2 * pad_;
  const std::size_t size = static_cast<std::size_t>(stride_) * static_cast<std::size_t>(rows);
  for (std::vector<std::uint8_t>& level : levels_) level.assign(size + kLanes, 0);
}

void LikelihoodImage::rasterize(const SurfelField& surface, const ReachMask& reached,
                                double sigma_m) {
  const float resolution = surface.resolution();
  const std::vector<std::uint8_t> table =
      likelihoodTable(sigma_m / static_cast<double>(resolution));
  const auto last = static_cast<float>(table.size() - 1);
  const float steps = kTableSteps / (resolution * resolution);
  reached.forEach([&](int x, int y) {
    const Cell corner = reached.corner(x, y), pixel = inImage(corner);
    std::uint8_t* out =
        levels_[0].data() + static_cast<std::ptrdiff_t>(pixel.y) * stride_ + pixel.x;
    surface.forEachNearest(corner, ReachMask::kSide, [&](int i, int j, float distance2) {
      const int index = static_cast<int>(std::min(distance2 * steps + 0.5F, last));
      out[j * stride_ + i] = table[static_cast<std::size_t>(index)];
    });
  });
}

/// Fills a level where windows can be nonzero. `window_starts` are the blocks of their first cells.
void LikelihoodImage::buildLevel(int level, const ReachMask& window_starts) {
  std::vector<std::uint8_t> pairs(static_cast<std::size_t>(stride_) + 1, 0);
  for (int block = 0; block < window_starts.height(); ++block) {
    const auto [first, last] = window_starts.span(block);
    if (first == last) continue;
    const Cell low = inImage(window_starts.corner(first, block));
    const Cell high = inImage(window_starts.corner(last, block));
    for (int y = low.y; y < low.y + ReachMask::kSide; ++y) {
      buildRow(level, y, low.x, high.x, pairs);
    }
  }
}

/// A window of size 2^k consists of four windows of size 2^(k - 1). `pairs` is a buffer for a row.
void LikelihoodImage::buildRow(int level, int y, int x0, int x1, std::vector<std::uint8_t>& pairs) {
  const int half = 1 << (level - 1), unit = 2 * half;
  const int from = x0 / unit, to = (x1 + unit - 1) / unit;
  const std::ptrdiff_t run = stride_ / unit;  // length of one phase
  const std::uint8_t* lower = levels_[static_cast<std::size_t>(level - 1)].data() +
                              static_cast<std::ptrdiff_t>(y) * stride_;
  const std::uint8_t* upper = lower + static_cast<std::ptrdiff_t>(half) * stride_;
  std::uint8_t* out =
      levels_[static_cast<std::size_t>(level)].data() + static_cast<std::ptrdiff_t>(y) * stride_;
  for (int phase = 0; phase < half; ++phase) {
    const std::ptrdiff_t begin = 2 * (phase * run + from), length = 2 * (to - from) + 1;
    const std::uint8_t *a = lower + begin, *b = upper + begin;
    std::uint8_t* pair = pairs.data();
    if (level == 1) {
      for (std::ptrdiff_t i = 0; i < length; ++i) pair[i] = coarse(std::max(a[i], b[i]));
    } else {
      for (std::ptrdiff_t i = 0; i < length; ++i) pair[i] = std::max(a[i], b[i]);
    }
    std::uint8_t* even = out + phase * run + from;
    std::uint8_t* odd = even + half * run;
    for (int i = 0; i < to - from; ++i) {
      even[i] = std::max(pair[2 * i], pair[2 * i + 1]);
      odd[i] = std::max(pair[2 * i + 1], pair[2 * i + 2]);
    }
  }
}

}  // namespace kestrel
