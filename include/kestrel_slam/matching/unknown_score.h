// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace kestrel {

/// A point in unknown space counts as much as a point does on average at a wrong place: it says
/// nothing for a pose and nothing against it. With 0, a place that was seen in part would lose
/// against one that contradicts the scan.
constexpr double kUnknownScore = 0.25;

}  // namespace kestrel
