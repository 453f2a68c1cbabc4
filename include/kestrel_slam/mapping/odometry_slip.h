// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/matching/match_result.h"
#include "kestrel_slam/matching/matcher.h"

namespace kestrel {

/// Where a scan fits beside the pose by the odometry.
struct FitAfterSlip {
  std::optional<MatchResult> match;  ///< it fits well, and clearly better than anywhere else
  bool is_reverse = false;           ///< there the reverse of the motion leads
  bool ambiguous = false;            ///< it fits nearly as well as at the pose that was found
};

/// How the odometry may be wrong.
struct SlipKind {
  bool any = true;       ///< the wheels may have slipped
  bool reverse = false;  ///< the vehicle may have driven back
};

/// Searches for a scan that contradicts the odometry. The wheels may have slipped, or the odometry
/// does not know the direction: then the vehicle is anywhere within the distance that the odometry
/// measured. `last`: map_T_base of the scan before. `found`: the match near the odometry. Nothing
/// without an odometry. Where the reverse of the motion leads, a poor fit is enough, as it is near
/// the odometry, if it is clearly better than all others.
FitAfterSlip matchAfterSlip(const Submap& map, const MatchRequest& request, const Pose2& last,
                            const MatchResult& found, const MatcherConfig& config,
                            const SlipKind& kind = {});

}  // namespace kestrel
