// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/graph/loop.h"
#include "kestrel_slam/graph/places.h"
#include "kestrel_slam/merging/search_memory.h"

namespace kestrel {

/// A loop with a place as numbers. Without its reason: merging counts the loops that are not
/// refused.
inline SearchMemory::Numbers numbersOf(const Loop& loop, const KnownPlace& place) {
  const Pose2& pose = loop.anchor_T_query.mean;
  const Eigen::Matrix3d& c = loop.anchor_T_query.covariance;
  return {static_cast<double>(loop.anchor - place.first),
          static_cast<double>(loop.state),
          pose.x,
          pose.y,
          pose.yaw,
          c(0, 0),
          c(0, 1),
          c(0, 2),
          c(1, 1),
          c(1, 2),
          c(2, 2),
          loop.fit,
          loop.known,
          loop.constraint};
}

inline Loop loopOf(const SearchMemory::Numbers& numbers, const KnownPlace& place,
                   std::size_t query) {
  Loop loop;
  loop.anchor = place.first + static_cast<std::size_t>(numbers[0]);
  loop.query = query;
  loop.state = static_cast<LoopState>(static_cast<int>(numbers[1]));
  loop.anchor_T_query.mean = {numbers[2], numbers[3], numbers[4]};
  loop.anchor_T_query.covariance << numbers[5], numbers[6], numbers[7],  //
      numbers[6], numbers[8], numbers[9],                                //
      numbers[7], numbers[9], numbers[10];
  loop.fit = numbers[11];
  loop.known = numbers[12];
  loop.constraint = numbers[13];
  return loop;
}

}  // namespace kestrel
