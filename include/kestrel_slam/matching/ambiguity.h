// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "kestrel_slam/matching/matcher.h"

namespace kestrel {

/// The second explanation is nearly as good if its score is lower by less than this.
constexpr double kClearlyBetter = 0.1;

/// Searches the window of `request` for a second pose at which the scan fits nearly as well as at
/// `found` (its score is lower by less than `margin`), as in a room that looks the same after a
/// rotation. Poses near `found` do not count, and
/// neither do those along `found.degenerate_direction`, which is already known to be unobservable.
/// If the limited work does not suffice for the whole window, the best other pose that was found is
/// returned, however well it fits: it may not be unique.
std::optional<Pose2> secondExplanation(const Submap& map, const MatchRequest& request,
                                       const MatchResult& found, const MatcherConfig& config,
                                       double margin = kClearlyBetter);

}  // namespace kestrel
