// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "kestrel_slam/evaluation/evaluation.h"

namespace kestrel {

/// Writes a PNG: the trajectory (with the reference, where there is one), and the errors over time.
void plotEvaluation(const std::string& path, const Trajectory& trajectory,
                    const std::optional<RelationEvaluation>& relations,
                    const std::optional<ReferenceEvaluation>& reference);

}  // namespace kestrel
