// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "kestrel_slam/geometry/pose_covariance.h"
#include "kestrel_slam/graph/pose_graph.h"
#include "kestrel_slam/graph/wall_agreement.h"

namespace kestrel {

/// Parameters of the loop search. All defaults are defined here.
struct LoopConfig {
  bool enabled = true;          ///< false: no search
  int query_keyframes = 10;     ///< consecutive keyframes that are searched for together
  double query_path_m = 4.0;    ///< or half of them, if their path has this length
  double least_radius_m = 1.5;  ///< half size of the search window where the graph is certain
  double wide_radius_m = 6.0;   ///< the same in every fourth search: a slip is not in the graph.
                                ///< The place must be unique in at least this window.
  double most_radius_m = 15.0;  ///< the largest half size
  double min_fit = 0.65;        ///< fit of the query where the place is known, 0 to 1
  double min_known = 0.6;       ///< share of the query in the known part of the place
  /// Share of the query that constrains the weakest direction. With less, the loop gives less
  /// information about this direction.
  double min_constraint = 0.04;
  double min_margin = 0.08;    ///< by which the fit is better than anywhere else in the window
  double min_agreement = 0.7;  ///< share of the single scans that fit at the same place
  double max_contradiction = kMostContradiction;  ///< share of the walls
};

/// What became of a loop that was found.
enum class LoopState {
  kPending,  ///< it waits for another one that confirms it
  kAccepted,
  kRefused,
  kUndone  ///< it was accepted, and the optimized graph contradicts it
};

const char* toString(LoopState state);

/// A place that looks like one that the vehicle visited before, and how well.
struct Loop {
  std::size_t anchor = 0;        ///< keyframe of the first visit
  std::size_t query = 0;         ///< keyframe of the second visit
  GaussianPose2 anchor_T_query;  ///< as matched
  double fit = 0.0;              ///< 0 to 1
  double known = 0.0;            ///< 0 to 1
  double constraint = 0.0;       ///< share of the beams, 0 to 0.5
  double margin = 0.0;           ///< of the fit to the second explanation
  double agreement = 0.0;        ///< share of the single scans
  double radius_m = 0.0;         ///< of the search; 0: only matched where the graph expected it
  double correction_m = 0.0;     ///< distance from where the graph expected the query
  LoopState state = LoopState::kRefused;
  std::string reason;  ///< why it is pending, refused or undone
};

/// The edge of an accepted loop.
PoseEdge graphEdgeOf(const Loop& loop);

}  // namespace kestrel
