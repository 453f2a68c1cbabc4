// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/match_result.h"
#include "kestrel_slam/matching/matcher.h"

namespace kestrel {

/// Result of matchPlace.
struct PlaceMatch {
  MatchResult match;  ///< the best pose
  /// How well the points fit at the best pose and at the best one that is not near it: mean over
  /// all points, 0 to 1. Points in unknown space count as 0.
  double score = 0.0, second_score = 0.0;
  bool complete = true;  ///< the whole window was searched
};

/// Whether `other` and `match` are one explanation, as those that are compared in matchPlace.
bool isSamePlace(const MatchResult& match, const Pose2& other);

/// Finds `points` (base frame, m) in a map without any preference for the center of the window:
/// the question is whether this is the same place, and whether the points fit in one way only.
/// `work`: limit of the search, see WorkBudget.
PlaceMatch matchPlace(const Submap& place, const Points& points, const Pose2& center,
                      const SearchWindow& window, const MatcherConfig& config, std::int64_t work);

/// The local optimum near `guess`, without a search.
MatchResult matchNear(const Submap& place, const Points& points, const Pose2& guess,
                      const MatcherConfig& config);

}  // namespace kestrel
