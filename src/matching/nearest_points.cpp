// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/nearest_points.h"

#include <nanoflann.hpp>

namespace kestrel {
namespace {

/// The interface that nanoflann needs.
struct Cloud {
  std::vector<WallPoint> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t index, std::size_t dimension) const {
    return points[index].position[static_cast<Eigen::Index>(dimension)];
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

using Metric = nanoflann::L2_Simple_Adaptor<float, Cloud>;
using Index = nanoflann::KDTreeSingleIndexAdaptor<Metric, Cloud, 2>;

/// Points per leaf. The fastest of 4 to 32 for the pairs of a scan.
constexpr std::size_t kLeafSize = 10;

}  // namespace

struct NearestPoints::Tree {
  explicit Tree(std::vector<WallPoint> points)
      : cloud{std::move(points)}, index(2, cloud, {kLeafSize}) {
#if NANOFLANN_VERSION < 0x140  // the constructor of 1.3 (Ubuntu 20.04) does not build the tree
    index.buildIndex();
#endif
  }

  Cloud cloud;
  Index index;
};

NearestPoints::NearestPoints(std::vector<WallPoint> points)
    : tree_(std::make_unique<Tree>(std::move(points))) {}
NearestPoints::~NearestPoints() = default;

const WallPoint* NearestPoints::nearest(const Eigen::Vector2f& place, float reach_m) const {
  NearestWithin result{reach_m * reach_m};
  tree_->index.radiusSearchCustomCallback(place.data(), result);
  return result.empty() ? nullptr : &tree_->cloud.points[result.index];
}

std::size_t NearestPoints::size() const { return tree_->cloud.points.size(); }

}  // namespace kestrel
