// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "kestrel_slam/map/tile_map.h"

namespace kestrel {

/// Half the widths of the rows of a disk, in cells, from row -radius on.
template <int radius>
constexpr std::array<int, 2 * radius + 1> halfWidthsOfDisk() {
  std::array<int, 2 * radius + 1> widths{};
  for (int row = -radius; row <= radius; ++row) {
    int& width = widths[static_cast<std::size_t>(row + radius)];
    while ((width + 1) * (width + 1) + row * row <= radius * radius) ++width;
  }
  return widths;
}

/// Cells side by side, each with its nearest surfel and the squared distance to it.
struct NearestRow {
  std::uint16_t* distance2;  ///< in steps
  std::uint32_t* nearest;
  int count;
};

/// Vector types of GCC and Clang.
using FourFloats = float __attribute__((vector_size(16)));
using FourShorts = std::uint16_t __attribute__((vector_size(8)));

/// attachRow for the four cells that begin with the one at `place`. `x`: of their centers.
inline void attachFour(std::uint32_t id, const FourFloats& x, float y2, float steps,
                       const NearestRow& row, int place) {
  std::uint16_t* distance2 = row.distance2 + place;
  std::uint32_t* nearest = row.nearest + place;
  const FourInts d2 = __builtin_convertvector((x * x + y2) * steps, FourInts) + 1;
  FourShorts values;
  std::memcpy(&values, distance2, sizeof(values));
  const FourInts old = __builtin_convertvector(values, FourInts);
  const FourInts is_nearer = d2 < old;
  std::array<std::uint64_t, 2> halves;
  std::memcpy(halves.data(), &is_nearer, sizeof(is_nearer));
  // Most cells around a new surfel of a wall have a nearer one.
  if ((halves[0] | halves[1]) == 0U) return;
  values = __builtin_convertvector((d2 & is_nearer) | (old & ~is_nearer), FourShorts);
  std::memcpy(distance2, &values, sizeof(values));
  FourInts ids;
  std::memcpy(&ids, nearest, sizeof(ids));
  ids = (static_cast<std::int32_t>(id) & is_nearer) | (ids & ~is_nearer);
  std::memcpy(nearest, &ids, sizeof(ids));
}

/// Attaches to a surfel those cells that are nearer to it than to theirs. (x, y): from the mean of
/// the surfel to the center of the first cell, in cells. `steps`: per squared cell; all distances
/// of the row to the surfel fit into 16 bits.
inline void attachRow(std::uint32_t id, float x, float y, float steps, const NearestRow& row) {
  constexpr int kFour = 4;
  const float y2 = y * y;
  if (row.count < kFour) {
    for (int i = 0; i < row.count; ++i) {
      const float ex = x + static_cast<float>(i);
      const int d2 = static_cast<int>((ex * ex + y2) * steps) + 1;
      if (d2 >= row.distance2[i]) continue;
      row.distance2[i] = static_cast<std::uint16_t>(d2);
      row.nearest[i] = id;
    }
    return;
  }
  FourFloats four = FourFloats{0.0F, 1.0F, 2.0F, 3.0F} + x;
  int i = 0;
  for (; i + kFour <= row.count; i += kFour, four += static_cast<float>(kFour))
    attachFour(id, four, y2, steps, row, i);
  if (i == row.count) return;
  // The last four overlap with those before: a cell that is attached twice stays as it is.
  const int last = row.count - kFour;
  attachFour(id, four + static_cast<float>(last - i), y2, steps, row, last);
}

}  // namespace kestrel
