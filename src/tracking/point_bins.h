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

  /// Calls `visit(index)` for all points within the radius of `center`.
  template <typename Visit>
  void forEachNear(const Vector& center, Visit visit) const {
    const Bin middle = binOf(center);
    Bin bin = middle;
    // The last coordinate runs over three neighbors in one piece of the sorted list.
    constexpr int kRows = D == 2 ? 3 : 9;
    for (int row = 0; row < kRows; ++row) {
      bin[0] = middle[0] + row % 3 - 1;
      if constexpr (D == 3) bin[1] = middle[1] + row / 3 - 1;
      bin[D - 1] = middle[D - 1] - 1;
      const std::uint64_t first = keyOf(bin);
      bin[D - 1] = middle[D - 1] + 1;
      const std::uint64_t last = keyOf(bin);
      auto entry = std::lower_bound(bins_.begin(), bins_.end(), std::pair(first, std::size_t{0}));
      for (; entry != bins_.end() && entry->first <= last; ++entry) {
        const double distance2 = (points_[entry->second] - center).squaredNorm();
        if (distance2 <= radius_ * radius_) visit(entry->second);
      }
    }
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
