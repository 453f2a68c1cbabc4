// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace kestrel {

/// How far the beams of a sweep go in each direction: tells whether the lidar can see a place.
class LidarView {
 public:
  /// `points`: in the frame of the lidar.
  LidarView(const std::vector<Eigen::Vector3f>& points, const Eigen::Isometry3d& map_T_lidar);

  /// Share of an upright object of this size (m) around `center` (in the map) that beams reach: 0
  /// outside of the field of view and behind something, 1 if nothing is in between. A direction
  /// without returns hides nothing.
  double visibleShare(const Eigen::Vector3d& center, double width, double height) const;
  /// True if a beam goes through the place (in the map) and ends behind it.
  bool isPassed(const Eigen::Vector3d& place) const;
  const Eigen::Vector3d& lidar() const { return lidar_; }
  double rangeOf(const Eigen::Vector3d& point) const { return (point - lidar_).norm(); }

 private:
  static constexpr int kColumns = 720, kRows = 48;

  std::optional<float> reachTo(const Eigen::Vector3f& in_lidar) const;
  bool isVisible(const Eigen::Vector3f& in_lidar, float margin) const;

  Eigen::Isometry3f to_lidar_;
  Eigen::Vector3d lidar_;
  float lowest_ = 0.0F, step_ = 1.0F;  ///< tangent of the elevation of the first row, and per row
  std::vector<float> reach_;           ///< farthest return, m; negative: none
  std::vector<bool> has_column_;
};

}  // namespace kestrel
