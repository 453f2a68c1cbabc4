// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "kestrel_slam/lidar/cloud_tracker.h"

namespace kestrel {

/// The whole static map of a run: the tracker itself forgets what is far away.
class StaticMap {
 public:
  explicit StaticMap(double resolution) : resolution_(resolution) {}

  /// Takes over the surfaces of the tracker, but not those that have become free since: what stood
  /// there has left. Call it at least every 50 m.
  void add(const CloudTracker& tracker);

  /// Centroids of the voxels that are still occupied.
  std::vector<Eigen::Vector3f> points() const;
  /// The content of a binary PCD file.
  std::string pcd() const;
  /// The content of an OctoMap file (.bt): occupied leaves, and free ones between them and the
  /// places of the lidar.
  std::string octomap() const;

 private:
  double resolution_;
  VoxelTable table_;
  std::vector<Eigen::Vector3f> points_;
  std::vector<Eigen::Vector3f> seen_from_;  ///< of each point
  std::vector<bool> occupied_;
};

}  // namespace kestrel
