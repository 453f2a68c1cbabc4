// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/offline/offline_run.h"

namespace kestrel {

/// What one method made of a recording.
struct MethodRun {
  std::string method;
  OfflineRun run;
};

/// The errors of several methods on the same recording, or how far they are from one of them.
struct MatcherComparison {
  /// Of the relations, at the later of their two stamps; or of every scan.
  struct Errors {
    std::string method;
    std::vector<PoseError> errors;
    PoseErrorStatistics statistics;
  };
  std::string reference;       ///< the method that distances are measured from; empty: relations
  std::vector<Errors> errors;  ///< in the order of the runs; none of the reference itself
};

/// Compares by relations where there are any, else by the distance from the trajectory of the run
/// called `reference`, or of the first where there is none. Nothing is aligned: every run begins in
/// the same pose. Throws std::runtime_error where no relation has both of its scans in the runs.
MatcherComparison compareRuns(const std::vector<MethodRun>& runs,
                              const std::optional<std::vector<Relation>>& relations,
                              const std::string& reference);

/// The figures as a Markdown table; without `timing` none that were measured.
std::string comparisonTable(const std::vector<MethodRun>& runs, const MatcherComparison& comparison,
                            bool timing);

/// Writes a PNG: the trajectories, and the errors in translation and rotation over time.
void plotComparison(const std::string& path, const std::vector<MethodRun>& runs,
                    const MatcherComparison& comparison);

}  // namespace kestrel
