// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "kestrel_slam/graph/loop_matcher.h"
#include "kestrel_slam/merging/joint_map.h"

namespace kestrel {

/// Where a guess puts a query, and how far from there it is searched.
struct ExpectedPlace {
  Pose2 map_T_map;  ///< from the query's map to the map that is searched
  double radius_m = 5.0;
  double yaw_rad = 0.5;
};

/// Finds what several vehicles have seen.
class CommonPlaces {
 public:
  CommonPlaces(const MapperConfig& mapper, const LoopConfig& config)
      : mapper_(mapper), config_(config), matcher_(mapper.matcher, config) {}

  /// Searches for a query in the whole map of a part of `joint`, with all yaws. The loop is pending
  /// if it fits well in exactly one place of this map; otherwise it is refused and has a reason.
  Loop search(JointMap& joint, std::size_t part, const LoopQuery& query) const;

  /// The same around a guess.
  Loop searchNear(JointMap& joint, std::size_t part, const LoopQuery& query,
                  const ExpectedPlace& expected) const;

 private:
  /// The best pose of the query in one place.
  struct Found {
    std::size_t place = 0;
    Pose2 pose;
    double score = -1.0, second = 0.0;
    bool complete = true;
  };

  Found searchPlace(JointMap& joint, std::size_t place, const Points& points) const;
  static double secondScore(const std::vector<Found>& found, const Found& best);
  Loop verified(JointMap& joint, const LoopQuery& query, const Found& best) const;

  MapperConfig mapper_;
  LoopConfig config_;
  LoopMatcher matcher_;
};

}  // namespace kestrel
