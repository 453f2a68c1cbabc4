// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/graph/loop_matcher.h"
#include "kestrel_slam/merging/joint_map.h"

namespace kestrel {

/// What the keyframes say that lie in the map of another vehicle, if the maps are joined.
struct Overlap {
  std::vector<Loop> agreeing;     ///< keyframes that fit where they are expected
  std::size_t sampled = 0;        ///< keyframes that were looked at
  std::size_t compared = 0;       ///< of these, keyframes in the known part of the other map
  std::size_t contradicting = 0;  ///< of these, keyframes that do not fit
  /// The longest way along which none fits, m. In the same building this is a door that was closed;
  /// in another one it is a room that differs.
  double longest_contradiction_m = 0.0;

  /// The share of all keyframes that lie in the other map and fit.
  double fittingShare() const {
    return sampled == 0
               ? 0.0
               : static_cast<double>(compared - contradicting) / static_cast<double>(sampled);
  }
  void add(const Overlap& other);
};

/// Compares the keyframes of the part `query` with the places of the part `map`. `poses`: of all
/// keyframes, in one frame.
Overlap compareOverlap(JointMap& joint, const LoopMatcher& matcher,
                       const std::vector<PoseVertex>& poses, std::size_t map, std::size_t query,
                       SearchMemory& memory);

}  // namespace kestrel
