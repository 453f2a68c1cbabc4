// SPDX-License-Identifier: BSD-3-Clause
#include "strip_bounds.h"

#include <algorithm>
#include <cstring>

namespace kestrel {
namespace {

constexpr int kLanes = StripBounds::kLanes;
/// After so many groups of points it is checked whether a lane is left.
constexpr std::size_t kChunk = 2;

std::array<std::uint8_t, kLanes> rowOf(int value) {
  std::array<std::uint8_t, kLanes> result{};
  result.fill(static_cast<std::uint8_t>(value));
  return result;
}

const std::array<std::uint8_t, kLanes> kUnknownRow = rowOf(BoundImages::kUnknown);
const std::array<std::uint8_t, kLanes> kNothing = rowOf(0);

/// The values of a point in all lanes. The image has a margin: a strip that reaches out of it is
/// unknown as a whole.
inline const std::uint8_t* rowAt(const BoundImages& images, const RotatedPoint& p, int x, int y) {
  const int column = x + p.x, row = y + p.y;
  const bool inside =
      images.contains(column, row) && images.contains(column + 4 * (kLanes - 1), row);
  return inside ? images.at(p.image, column, row) : kUnknownRow.data();
}

}  // namespace

inline std::array<StripBounds::HalfRow, 2> StripBounds::halvesOf(const Row& row) {
  std::array<HalfRow, 2> result;
  std::memcpy(result.data(), &row, sizeof row);
  return result;
}

inline void StripBounds::Sums::add(const Row& row) {
  const std::array<HalfRow, 2> halves = halvesOf(row);
  low += __builtin_convertvector(halves[0], HalfSums);
  high += __builtin_convertvector(halves[1], HalfSums);
}

inline void StripBounds::Sums::subtract(const Row& row) {
  const std::array<HalfRow, 2> halves = halvesOf(row);
  low -= __builtin_convertvector(halves[0], HalfSums);
  high -= __builtin_convertvector(halves[1], HalfSums);
}

inline bool StripBounds::Sums::reach(int limit) const {
  const HalfSums least = HalfSums{} + static_cast<std::int16_t>(limit);
  const HalfSums any = (low >= least) | (high >= least);
  std::array<std::uint64_t, 2> words{};
  std::memcpy(words.data(), &any, sizeof any);
  return (words[0] | words[1]) != 0;
}

inline void StripBounds::Sums::ignore(std::size_t lane) {
  (lane < kLanes / 2 ? low : high)[lane % (kLanes / 2)] = -1;
}

std::array<std::int16_t, kLanes> StripBounds::values(const Sums& sums) {
  std::array<std::int16_t, kLanes> result{};
  std::memcpy(result.data(), &sums.low, sizeof sums.low);
  std::memcpy(result.data() + kLanes / 2, &sums.high, sizeof sums.high);
  return result;
}

inline StripBounds::Row StripBounds::sumOf(const std::array<const std::uint8_t*, kTogether>& rows) {
  Row result{};
  for (const std::uint8_t* row : rows) {
    Row values;
    std::memcpy(&values, row, sizeof values);
    result += values;
  }
  return result;
}

void StripBounds::set(const BoundImages& images, const std::vector<RotatedPoint>& points, int x,
                      int y, unsigned lanes) {
  rows_.clear();
  for (const RotatedPoint& p : points) rows_.push_back(rowAt(images, p, x, y));
  while (rows_.size() % kTogether != 0) rows_.push_back(kNothing.data());
  lookups_ += static_cast<std::int64_t>(rows_.size());
  whole_ = Sums();
  for (std::size_t n = 0; n < rows_.size(); n += kTogether)
    whole_.add(sumOf({rows_[n], rows_[n + 1], rows_[n + 2], rows_[n + 3]}));
  const std::array<std::int16_t, kLanes> sums = values(whole_);
  std::size_t best = 0;
  for (std::size_t i = 0; i < kLanes; ++i) {
    if ((lanes >> i & 1U) == 0) {
      whole_.ignore(i);
    } else if (sums[i] > sums[best] || (lanes >> best & 1U) == 0) {
      best = i;
    }
  }
  sort(best);
  groups_.resize(rows_.size() / kTogether);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const std::uint32_t* n = &order_[g * kTogether];
    groups_[g] = sumOf({rows_[n[0]], rows_[n[1]], rows_[n[2]], rows_[n[3]]});
  }
}

/// The points with much to lose in this lane first.
void StripBounds::sort(std::size_t lane) {
  order_.resize(rows_.size());
  std::size_t first = 0, last = rows_.size();
  for (std::uint32_t n = 0; n < rows_.size(); ++n)
    order_[rows_[n][lane] > BoundImages::kMax / 2 ? first++ : --last] = n;
}

unsigned StripBounds::within(const BoundImages& images, const std::vector<RotatedPoint>& points,
                             int x, int y, int limit) {
  Sums left = whole_;
  const auto row = [&](std::uint32_t n) {
    return n < points.size() ? rowAt(images, points[n], x, y) : kNothing.data();
  };
  for (std::size_t g = 0; g < groups_.size();) {
    const std::size_t end = std::min(g + kChunk, groups_.size());
    lookups_ += static_cast<std::int64_t>((end - g) * kTogether);
    for (; g < end; ++g) {
      const std::uint32_t* n = &order_[g * kTogether];
      left.add(sumOf({row(n[0]), row(n[1]), row(n[2]), row(n[3])}));
      left.subtract(groups_[g]);
    }
    if (!left.reach(limit)) return 0;
  }
  unsigned result = 0;
  sums_ = values(left);
  for (std::size_t i = 0; i < kLanes; ++i)
    if (sums_[i] >= limit) result |= 1U << i;
  return result;
}

}  // namespace kestrel
