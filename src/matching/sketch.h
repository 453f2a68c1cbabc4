// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "kestrel_slam/matching/gauss_newton.h"
#include "kestrel_slam/matching/shared_search.h"
#include "kestrel_slam/matching/work_budget.h"

namespace kestrel {

/// Number of points for a sketch.
constexpr std::size_t kSketchPoints = 100;

/// A short descent from a hypothesis with a sample of the points, to see whether the scan fits.
Pose2 sketch(const SurfelField& surface, const Points& sample, const Pose2& hypothesis);

/// Sketches of as many hypotheses as the budget allows, in their order. After the first stage only
/// the half that fits best goes on, at least `least` of them (successive halving [Jamieson and
/// Talwalkar 2016]). A memory must be one of this map and sample.
std::vector<Pose2> sketches(const SurfelField& surface, const Points& sample,
                            const std::vector<Pose2>& hypotheses, std::size_t least,
                            WorkBudget& budget, SharedSearch* memory = nullptr);

}  // namespace kestrel
