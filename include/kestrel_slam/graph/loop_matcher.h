// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/graph/loop.h"
#include "kestrel_slam/graph/places.h"
#include "kestrel_slam/mapping/mapper_config.h"
#include "kestrel_slam/matching/correlative.h"

namespace kestrel {

/// Consecutive keyframes that are matched together: one scan alone fits in more places.
struct LoopQuery {
  std::size_t first = 0, last = 0;  ///< keyframes [first, last)
  std::size_t middle() const { return (first + last) / 2; }
};

/// Matches keyframes with a place and judges whether they were taken there.
class LoopMatcher {
 public:
  LoopMatcher(const MatcherConfig& matcher, const LoopConfig& config)
      : matcher_(matcher), config_(config) {}
  void configure(const LoopConfig& config) { config_ = config; }

  /// Searches for the query within `radius_m` and `yaw_rad` of `expected` (local_T_base of its
  /// middle keyframe, in the local frame of the place).
  Loop search(const Submap& map, const KnownPlace& place,
              const std::vector<LocalKeyframe>& keyframes, const LoopQuery& query,
              const Pose2& expected, double radius_m, double yaw_rad) const;

  /// Matches one keyframe where the graph expects it, at most `radius_m` away.
  Loop matchExpected(const Submap& map, const KnownPlace& place,
                     const std::vector<LocalKeyframe>& keyframes, std::size_t keyframe,
                     const Pose2& expected, double radius_m) const;

 private:
  Loop loopAt(const KnownPlace& place, const std::vector<LocalKeyframe>& keyframes,
              std::size_t query, const MatchResult& match) const;
  const char* problemOf(const Loop& loop) const;
  double agreementAt(const Submap& map, const std::vector<LocalKeyframe>& keyframes,
                     const LoopQuery& query, const MatchResult& found) const;
  bool contradicts(const Submap& map, const std::vector<LocalKeyframe>& keyframes,
                   const LoopQuery& query, const Pose2& local_T_found) const;
  bool agrees(const MatchResult& single, const Pose2& expected, const MatchResult& found) const;

  MatcherConfig matcher_;
  LoopConfig config_;
};

}  // namespace kestrel
