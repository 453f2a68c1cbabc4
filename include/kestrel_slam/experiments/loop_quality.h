// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "kestrel_slam/offline/graph_result.h"

namespace kestrel {

/// The loops of a flight, compared with the truth.
struct LoopQuality {
  std::size_t accepted = 0;
  std::size_t wrong = 0;     ///< of the accepted ones: by more than kWrongLoop
  double worst_m = 0.0;      ///< largest error of an accepted loop
  std::size_t revisits = 0;  ///< times of at least kRevisit near the path of an earlier visit
  std::size_t found = 0;     ///< revisits with an accepted loop that is not wrong
  /// Normalized squared errors of poses relative to the first one, with the covariances of the
  /// graph; 3 is expected. Only of flights with a loop.
  std::vector<double> nees;
};

constexpr double kWrongLoop = 0.3;      ///< m
constexpr double kRevisit = 5.0;        ///< s
constexpr double kNearPath = 1.5;       ///< m
constexpr double kEarlierVisit = 30.0;  ///< s between the visits

/// `truth`: the true poses of the scans. Stamps of keyframes that are not there are an error
/// (std::invalid_argument).
LoopQuality qualityOf(const GraphResult& result, const Trajectory& truth);

}  // namespace kestrel
