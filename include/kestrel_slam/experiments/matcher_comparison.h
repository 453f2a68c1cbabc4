// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/offline/offline_run.h"

namespace kestrel {

/// The run of one matching method on a recording.
struct MethodRun {
  std::string method;
  OfflineRun run;
};

/// The errors of several methods on the same recording, or their distances from one of the methods.
struct MatcherComparison {
  /// Errors of the relations, each at the later of its two stamps, or errors of all scans.
  struct Errors {
    std::string method;
    std::vector<PoseError> errors;
    PoseErrorStatistics statistics;
  };
  std::string reference;       ///< method that the others are compared with; empty: relations
  std::vector<Errors> errors;  ///< in the order of the runs, without the reference
};

/// Compares the runs with `relations`. Without relations, compares them with the trajectory of the
/// method `reference`, or of the first run if there is no such method. Trajectories are not
/// aligned, because all runs begin at the same pose. Throws std::runtime_error if no relation has
/// both scans in the runs.
MatcherComparison compareRuns(const std::vector<MethodRun>& runs,
                              const std::optional<std::vector<Relation>>& relations,
                              const std::string& reference);

/// The results as a Markdown table; measured times only if `timing` is true.
std::string comparisonTable(const std::vector<MethodRun>& runs, const MatcherComparison& comparison,
                            bool timing);

/// Writes a PNG with the trajectories and the errors of translation and rotation over time.
void plotComparison(const std::string& path, const std::vector<MethodRun>& runs,
                    const MatcherComparison& comparison);

}  // namespace kestrel
