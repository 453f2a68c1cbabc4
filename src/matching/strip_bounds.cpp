// SPDX-License-Identifier: BSD-3-Clause
#include "strip_bounds.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace kestrel {
namespace {

/// After so many groups of points it is checked whether a lane is left.
constexpr std::size_t kGroupsAtOnce = 2;

std::array<std::uint8_t, StripBounds::kLanes> filled(int value) {
  std::array<std::uint8_t, StripBounds::kLanes> result{};
  result.fill(static_cast<std::uint8_t>(value));
  return result;
}

const std::array<std::uint8_t, StripBounds::kLanes> kUnknownRow = filled(BoundImages::kUnknown);

/// The values of a point in all lanes.
inline const std::uint8_t* rowAt(const BoundImages& images, const RotatedPoint& p, int x, int y) {
  const std::uint8_t* row = images.stripAt(p.image, x + p.x, y + p.y);
  return row != nullptr ? row : kUnknownRow.data();
}

}  // namespace

RotatedPoints::RotatedPoints(const BoundImages& images, std::vector<RotatedPoint> points)
    : points_(std::move(points)) {
  constexpr int kPhases = 4;
  places_.reserve(kPhases * points_.size());
  for (int phase = 0; phase < kPhases; ++phase) {
    for (const RotatedPoint& p : points_)
      places_.push_back(images.placeFor(p.image, p.x, p.y, phase));
  }
  if (points_.empty()) return;
  low_ = high_ = {points_.front().x, points_.front().y};
  for (const RotatedPoint& p : points_) {
    low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
    high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y)};
  }
}

std::size_t RotatedPoints::memoryBytes() const {
  return points_.capacity() * sizeof(RotatedPoint) + places_.capacity() * sizeof(std::int32_t);
}

inline void StripBounds::Sums::add(const Row& row) {
  Words words;
  std::memcpy(&words, &row, sizeof row);
  even += words & 0xFF;
  odd += words >> 8;
}

inline void StripBounds::Sums::subtract(const Row& row) {
  Words words;
  std::memcpy(&words, &row, sizeof row);
  even -= words & 0xFF;
  odd -= words >> 8;
}

inline bool StripBounds::Sums::reach(int limit) const {
  using Signed = std::int16_t __attribute__((vector_size(kLanes)));
  Signed a, b;
  std::memcpy(&a, &even, sizeof a);
  std::memcpy(&b, &odd, sizeof b);
  const Signed least = Signed{} + static_cast<std::int16_t>(limit);
  const Signed any = (a >= least) | (b >= least);
  std::array<std::uint64_t, 2> words{};
  std::memcpy(words.data(), &any, sizeof any);
  return (words[0] | words[1]) != 0;
}

inline void StripBounds::Sums::ignore(std::size_t lane) {
  (lane % 2 == 0 ? even : odd)[lane / 2] = 0xFFFF;
}

std::array<std::int16_t, StripBounds::kLanes> StripBounds::values(const Sums& sums) {
  std::array<std::int16_t, kLanes> result{};
  for (std::size_t i = 0; i < kLanes; ++i)
    result[i] = static_cast<std::int16_t>((i % 2 == 0 ? sums.even : sums.odd)[i / 2]);
  return result;
}

inline StripBounds::Row StripBounds::rowOf(const std::uint8_t* values) {
  Row result;
  std::memcpy(&result, values, sizeof result);
  return result;
}

void StripBounds::set(const BoundImages& images, const RotatedPoints& points, int x, int y,
                      unsigned lanes) {
  rows_.clear();
  if (points.areIn(images, x, y)) {
    const std::uint8_t* rows = images.rows(x, y);
    const std::int32_t* places = points.places(x & 3);
    for (std::size_t n = 0; n < points.points().size(); ++n) rows_.push_back(rows + places[n]);
  } else {
    for (const RotatedPoint& p : points.points()) rows_.push_back(rowAt(images, p, x, y));
  }
  lookups_ += static_cast<std::int64_t>(rows_.size());
  whole_ = Sums();
  for (std::size_t n = 0; n < rows_.size(); n += kTogether)
    whole_.add(rowOf(rows_[n]) + rowOf(rows_[n + 1]) + rowOf(rows_[n + 2]) + rowOf(rows_[n + 3]));
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
    groups_[g] = rowOf(rows_[n[0]]) + rowOf(rows_[n[1]]) + rowOf(rows_[n[2]]) + rowOf(rows_[n[3]]);
  }
}

/// The points with much to lose in this lane first.
void StripBounds::sort(std::size_t lane) {
  order_.resize(rows_.size());
  std::size_t first = 0, last = rows_.size();
  for (std::uint32_t n = 0; n < rows_.size(); ++n)
    order_[rows_[n][lane] > BoundImages::kMax / 2 ? first++ : --last] = n;
}

/// `row`: the values of a point in the parts.
template <typename RowAt>
unsigned StripBounds::subtract(const RowAt& row, int limit) {
  Sums left = whole_;
  for (std::size_t g = 0; g < groups_.size();) {
    const std::size_t end = std::min(g + kGroupsAtOnce, groups_.size());
    lookups_ += static_cast<std::int64_t>((end - g) * kTogether);
    for (; g < end; ++g) {
      const std::uint32_t* n = &order_[g * kTogether];
      left.add(row(n[0]) + row(n[1]) + row(n[2]) + row(n[3]));
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

unsigned StripBounds::within(const BoundImages& images, const RotatedPoints& points, int x, int y,
                             int limit) {
  if (points.areIn(images, x, y)) {
    const std::uint8_t* rows = images.rows(x, y);
    const std::int32_t* places = points.places(x & 3);
    return subtract([rows, places](std::uint32_t n) { return rowOf(rows + places[n]); }, limit);
  }
  const std::vector<RotatedPoint>& all = points.points();
  return subtract([&](std::uint32_t n) { return rowOf(rowAt(images, all[n], x, y)); }, limit);
}

}  // namespace kestrel
