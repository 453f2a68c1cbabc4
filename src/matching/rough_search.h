// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/matching/correlative.h"
#include "kestrel_slam/matching/shared_search.h"
#include "kestrel_slam/matching/work_budget.h"

namespace kestrel {

/// A window to search in a rough image of the walls.
struct RoughWindow {
  Pose2 center;
  SearchWindow size;
  CorrelativeConfig preferences;  ///< penalty of the motion
  ExcludedPoses excluded;
  /// Number of searches of this window before. If the budget is too small for the whole window, it
  /// is divided: each search does the part around the center and some others in turn.
  int turn = 0;
  SharedSearch* memory = nullptr;  ///< of the searches for this scan in this map
};

/// Poses at which a scan may fit, best first.
struct Hypotheses {
  std::vector<Pose2> poses;
  bool complete = true;  ///< the whole window was searched
};

/// Searches a window in pixels of 20 cm, or of 40 cm if the budget is too small for the whole
/// window with 20 cm. The poses are only accurate to a pixel, and no two of them are near each
/// other: a descent from each of them shows which one fits. Needs far less time than searchWindow,
/// but it is not exact.
Hypotheses searchRoughly(const SurfelField& surface, const Points& points,
                         const RoughWindow& window, WorkBudget& budget);

}  // namespace kestrel
