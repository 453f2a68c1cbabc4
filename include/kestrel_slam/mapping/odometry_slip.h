// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/matching/match_result.h"
#include "kestrel_slam/matching/matcher.h"

namespace kestrel {

/// Where a scan fits that contradicts the odometry. The wheels may have slipped, or the odometry
/// does not know the direction: then the vehicle is anywhere within the distance that the odometry
/// measured. `last`: map_T_base of the scan before. `refused`: the match near the odometry, which
/// is not good enough. Nothing without an odometry, and if the scan does not fit well in one way
/// only.
std::optional<MatchResult> matchAfterSlip(const Submap& map, const MatchRequest& request,
                                          const Pose2& last, const MatchResult& refused,
                                          const MatcherConfig& config);

}  // namespace kestrel
