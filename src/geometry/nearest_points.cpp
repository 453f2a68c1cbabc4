// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/geometry/nearest_points.h"

#include <nanoflann.hpp>

namespace kestrel {
namespace {

/// The interface that nanoflann needs.
template <int D>
struct Cloud {
  std::vector<Eigen::Matrix<float, D, 1>> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t index, std::size_t dimension) const {
    return points[index][static_cast<Eigen::Index>(dimension)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

/// Keeps the nearest point within a radius. The result sets of nanoflann have no radius limit; with
/// one, the search is much faster for points without a neighbor.
struct NearestWithin {
  float distance2;
  std::size_t index = 0;
  std::size_t found = 0;

  bool addPoint(float other2, std::size_t other) {
    if (other2 < distance2) {
      distance2 = other2;
      index = other;
      found = 1;
    }
    return true;
  }
  float worstDist() const { return distance2; }
  bool full() const { return found != 0; }
  bool empty() const { return found == 0; }
  std::size_t size() const { return found; }
  void sort() const {}
};

/// Points per leaf. The fastest of 4 to 32 for the pairs of a scan.
constexpr std::size_t kLeafSize = 10;

}  // namespace

template <int D>
struct NearestPoints<D>::Tree {
  explicit Tree(std::vector<Point> points)
      : cloud{std::move(points)}, index(D, cloud, {kLeafSize}) {
#if NANOFLANN_VERSION < 0x140  // the constructor of 1.3 (Ubuntu 20.04) does not build the tree
    index.buildIndex();
#endif
  }

  Cloud<D> cloud;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud<D>>, Cloud<D>, D>
      index;
};

template <int D>
NearestPoints<D>::NearestPoints(std::vector<Point> points)
    : tree_(std::make_unique<Tree>(std::move(points))) {}

template <int D>
NearestPoints<D>::~NearestPoints() = default;

template <int D>
std::optional<std::size_t> NearestPoints<D>::nearest(const Point& place, float reach_m) const {
  NearestWithin result{reach_m * reach_m};
  tree_->index.radiusSearchCustomCallback(place.data(), result);
  if (result.empty()) return std::nullopt;
  return result.index;
}

template <int D>
std::size_t NearestPoints<D>::size() const {
  return tree_->cloud.points.size();
}

template class NearestPoints<2>;
template class NearestPoints<3>;

}  // namespace kestrel
