// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace kestrel {

/// Points in cells as large as a radius, sorted by cell: all points within the radius of a place
/// lie in the cell of the place and its neighbors.
template <int D>
class PointBins {
 public:
  using Vector = Eigen::Matrix<double, D, 1>;

  PointBins(const std::vector<Vector>& points, double radius)
      : points_(points), radius_(radius), bins_(points.size()) {
    for (std::size_t i = 0; i < points.size(); ++i) bins_[i] = {keyOf(binOf(points[i])), i};
    std::sort(bins_.begin(), bins_.end());
  }

  /// The sorted points of a cell and its neighbors. Places in one cell share them.
  struct Neighbors {
    std::array<std::int64_t, D> cell{};
    std::array<std::pair<std::size_t, std::size_t>, D == 2 ? 3 : 9> rows{};  ///< first, end
    bool is_known = false;
  };

  /// Calls `visit(index)` for all points within the radius of `center`. `neighbors`: of the last
  /// place, so that the next one needs no search.
  template <typename Visit>
  void forEachNear(const Vector& center, Neighbors& neighbors, Visit visit) const {
    const Bin middle = binOf(center);
    if (!neighbors.is_known || neighbors.cell != middle) neighbors = neighborsOf(middle);
    for (const auto& [first, end] : neighbors.rows) {
      for (std::size_t i = first; i < end; ++i) {
        const std::size_t point = bins_[i].second;
        if ((points_[point] - center).squaredNorm() <= radius_ * radius_) visit(point);
      }
    }
  }
  template <typename Visit>
  void forEachNear(const Vector& center, Visit visit) const {
    Neighbors neighbors;
    forEachNear(center, neighbors, visit);
  }

 private:
  using Bin = std::array<std::int64_t, D>;
  Bin binOf(const Vector& point) const {
    Bin bin;
    for (int i = 0; i < D; ++i) {
      bin[static_cast<std::size_t>(i)] = static_cast<std::int64_t>(std::floor(point(i) / radius_));
    }
    return bin;
  }

  Neighbors neighborsOf(const Bin& middle) const {
    Neighbors result;
    result.cell = middle;
    result.is_known = true;
    // The last coordinate runs over three neighbors in one piece of the sorted list.
    Bin bin = middle;
    for (std::size_t row = 0; row < result.rows.size(); ++row) {
      const auto number = static_cast<std::int64_t>(row);
      bin[0] = middle[0] + number % 3 - 1;
      if constexpr (D == 3) bin[1] = middle[1] + number / 3 - 1;
      bin[D - 1] = middle[D - 1] - 1;
      const std::uint64_t low = keyOf(bin);
      bin[D - 1] = middle[D - 1] + 1;
      const std::uint64_t high = keyOf(bin);
      const auto first =
          std::lower_bound(bins_.begin(), bins_.end(), std::pair(low, std::size_t{0}));
      const auto end =
          std::find_if(first, bins_.end(), [&](const auto& b) { return b.first > high; });
      result.rows[row] = {static_cast<std::size_t>(first - bins_.begin()),
                          static_cast<std::size_t>(end - bins_.begin())};
    }
    return result;
  }

  /// Sorted as the bins themselves. Points that are too far away share a bin.
  static std::uint64_t keyOf(const Bin& bin) {
    constexpr int kBits = 64 / D;
    constexpr std::int64_t kHalf = std::int64_t{1} << (kBits - 1);
    std::uint64_t key = 0;
    for (const std::int64_t value : bin) {
      const std::int64_t limited = std::clamp(value, -kHalf, kHalf - 1);
      key = key << kBits | static_cast<std::uint64_t>(limited + kHalf);
    }
    return key;
  }

  const std::vector<Vector>& points_;
  double radius_;
  std::vector<std::pair<std::uint64_t, std::size_t>> bins_;
};

}  // namespace kestrel
