// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "kestrel_slam/evaluation/evaluation.h"

namespace kestrel {

/// Writes a PNG and an SVG with the trajectory (and the reference, if there is one) and the errors
/// over time. `name`: of the trajectory's file.
void plotEvaluation(const std::string& path, const std::string& name, const Trajectory& trajectory,
                    const std::optional<RelationEvaluation>& relations,
                    const std::optional<ReferenceEvaluation>& reference);

}  // namespace kestrel
