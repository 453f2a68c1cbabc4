// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "kestrel_slam/recording/kitti_labels.h"

namespace kestrel {

/// What is known of a labeled object in one sweep.
struct LabelSighting {
  double stamp = 0.0;  ///< s
  long id = 0;
  std::string type;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< in a frame that does not move, m
  std::size_t points = 0;                           ///< returns in its box
  bool has_track = false;                           ///< shown or not
  bool is_shown = false;
  long track = 0;  ///< the shown one
};

struct LabelGoal {
  double min_speed = 1.0;       ///< m/s; slower objects do not count
  std::size_t min_points = 10;  ///< sweeps in which the object has fewer returns do not count
};

/// How a labeled object was tracked while it moved and was seen well.
struct LabeledObject {
  long id = 0;
  std::string type;
  std::size_t sweeps = 0;  ///< that count
  std::size_t shown = 0;   ///< of them, with a shown track
  std::size_t hidden = 0;  ///< of them, with a track that is not shown
  double speed = 0.0;      ///< mean, m/s
  std::set<long> tracks;   ///< that were shown on it
  double share() const {
    return sweeps > 0 ? static_cast<double>(shown) / static_cast<double>(sweeps) : 0.0;
  }
};

/// True if the point (frame of the label) is in the box of the label, grown by `margin` (m) to all
/// sides.
bool isInLabel(const KittiLabel& label, const Eigen::Vector3d& point, double margin);

/// One entry for each object that counts in any sweep, by rising id. The speed is that between the
/// sightings half a second before and after.
std::vector<LabeledObject> labeledObjects(const std::vector<LabelSighting>& sightings,
                                          const LabelGoal& goal);

}  // namespace kestrel
