// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace kestrel {

/// A point of a wall.
struct WallPoint {
  Eigen::Vector2f position;  ///< m
  Eigen::Vector2f normal;    ///< of the wall, unit vector; zero where unknown
};

/// Exact nearest neighbors among fixed points: a k-d tree.
class NearestPoints {
 public:
  explicit NearestPoints(std::vector<WallPoint> points);
  ~NearestPoints();
  NearestPoints(const NearestPoints&) = delete;
  NearestPoints& operator=(const NearestPoints&) = delete;

  /// The point nearest to `place`, or nullptr where none is nearer than `reach_m`.
  const WallPoint* nearest(const Eigen::Vector2f& place, float reach_m) const;

  std::size_t size() const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace kestrel
