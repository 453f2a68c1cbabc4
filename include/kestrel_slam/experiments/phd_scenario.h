// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "kestrel_slam/tracking/phd_filter.h"

namespace kestrel {

/// A target of a scenario: state (x, y, vx, vy) one step before its first scan, first scan (1 or
/// later) and last scan. (In the Vo-Vo toolbox a target has moved by one step when it is seen
/// first.)
struct ScenarioTarget {
  Eigen::Vector4d state;
  int born, dies;
};

/// Point targets in clutter in a square of 2 km, 100 scans of 1 s.
struct PhdScenario {
  std::string name;
  std::vector<ScenarioTarget> targets;
  std::vector<PhdComponent<4>> births;
  std::vector<SpawnModel<4>> spawns;
  double clutter_per_scan = 60.0;
  double detection = 0.98, survival = 0.99;
  double acceleration_sigma = 5.0;  ///< m/s², of the filter; the true targets move straight on
  double position_sigma = 10.0;     ///< m, of a measurement in x and y
  /// Births at the observations that no target explains, instead of `births`.
  bool adaptive_birth = false;
  /// Labeled targets instead of the heavy components.
  bool labeled = false;
};

constexpr int kScenarioScans = 100;

/// The linear scenario of the Vo-Vo toolbox: twelve targets, no spawning.
PhdScenario standardScenario();
/// Example 1 of [Vo 2006]: two targets; the first spawns a third one in scan 66.
PhdScenario spawningScenario();

/// One run over all scans.
struct PhdScenarioRun {
  std::vector<double> ospa, localization, cardinality;  ///< of each scan, m; c = 100 m, p = 1
  double count_bias = 0.0;  ///< mean of estimated minus true number of targets
  /// Scans from the birth of each target to the first estimate within 100 m of it and nearer to it
  /// than to all other targets; -1: never.
  std::vector<int> found_after;
  std::size_t most_components = 0;
};

PhdScenarioRun runScenario(const PhdScenario& scenario, std::uint64_t seed);

/// Statistics of runs with the seeds 1, 2, ...
struct PhdScenarioSummary {
  std::size_t runs = 0;
  double ospa = 0.0, localization = 0.0, cardinality = 0.0;  ///< means over scans and runs, m
  double best = 0.0, worst = 0.0;                            ///< mean OSPA of single runs, m
  double sigma = 0.0;                                        ///< of the single runs, m
  double count_bias = 0.0;
  std::vector<PhdScenarioRun> single;

  /// Mean of the scans after which a target was found, over all that were.
  double foundAfter() const;
};

PhdScenarioSummary summarizeScenario(const PhdScenario& scenario, std::size_t runs);

}  // namespace kestrel
