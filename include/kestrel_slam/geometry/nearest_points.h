// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace kestrel {

/// Exact nearest neighbors among fixed points (k-d tree) in 2 or 3 dimensions.
template <int D>
class NearestPoints {
 public:
  using Point = Eigen::Matrix<float, D, 1>;

  explicit NearestPoints(std::vector<Point> points);
  ~NearestPoints();
  NearestPoints(const NearestPoints&) = delete;
  NearestPoints& operator=(const NearestPoints&) = delete;

  /// The number of the point nearest to `place` (m), if one is closer than `reach_m`.
  std::optional<std::size_t> nearest(const Point& place, float reach_m) const;

  std::size_t size() const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

extern template class NearestPoints<2>;
extern template class NearestPoints<3>;

}  // namespace kestrel
