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

  /// Searches for each query in the whole map of a part of `joint`, with all yaws. A loop is
  /// pending if it fits well in exactly one place of this map; otherwise it is refused. What is in
  /// `memory` is not searched for again.
  std::vector<Loop> search(JointMap& joint, std::size_t part, const std::vector<LoopQuery>& queries,
                           SearchMemory& memory) const;

  /// The same around a guess.
  Loop searchNear(JointMap& joint, std::size_t part, const LoopQuery& query,
                  const ExpectedPlace& expected) const;

 private:
  /// The best pose of the query in one place.
  struct Found {
    std::size_t place = 0;
    Pose2 local, map;  ///< the pose in the frame of the place, and in the map of its vehicle
    double score = -1.0, second = 0.0;
    bool complete = true;
  };

  SearchMemory::Numbers searchPlace(JointMap& joint, std::size_t place,
                                    const LoopQuery& query) const;
  static double secondScore(const std::vector<Found>& found, const Found& best);
  Loop judged(JointMap& joint, const LoopQuery& query, const std::vector<Found>& found,
              SearchMemory& memory) const;
  Loop verified(JointMap& joint, const LoopQuery& query, const Found& best,
                SearchMemory& memory) const;

  MapperConfig mapper_;
  LoopConfig config_;
  LoopMatcher matcher_;
};

}  // namespace kestrel
