// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace kestrel {

/// A point of a wall.
struct WallPoint {
  Eigen::Vector2f position;  ///< m
  Eigen::Vector2f normal;    ///< unit normal of the wall; zero if unknown
};

/// Exact nearest neighbors among fixed points (k-d tree).
class NearestPoints {
 public:
  explicit NearestPoints(std::vector<WallPoint> points);
  ~NearestPoints();
  NearestPoints(const NearestPoints&) = delete;
  NearestPoints& operator=(const NearestPoints&) = delete;

  /// The point nearest to `place` (m), or nullptr if none is closer than `reach_m`.
  const WallPoint* nearest(const Eigen::Vector2f& place, float reach_m) const;

  std::size_t size() const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace kestrel
