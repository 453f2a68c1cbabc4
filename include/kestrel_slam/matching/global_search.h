// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/gauss_newton.h"
#include "kestrel_slam/matching/work_budget.h"

namespace kestrel {

class BoundImages;

/// The walls and the free space of a whole map, prepared for searches. It is made once and serves
/// all searches until the map changes. `map` must outlive it.
class GlobalMap {
 public:
  explicit GlobalMap(const Submap& map);
  ~GlobalMap();
  GlobalMap(const GlobalMap&) = delete;
  GlobalMap& operator=(const GlobalMap&) = delete;

  const Submap& map() const { return map_; }
  const BoundImages& images() const { return *images_; }
  std::size_t memoryBytes() const;

 private:
  const Submap& map_;
  std::unique_ptr<BoundImages> images_;
};

/// A part of a map: the positions around a place.
struct MapRegion {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  ///< in the map frame, m
  double radius_m = 0.0;
};

struct GlobalSearchConfig {
  double min_score = 0.4;  ///< poses with a lower score are not of interest
  double margin = 0.15;    ///< neither are those that are so much worse than the best pose
  /// Poses that differ by less than this are one explanation.
  double same_m = 0.6, same_rad = 0.35;
  std::size_t most = 48;  ///< only so many of the best explanations are kept
  /// Only poses with a position in this region count, to the size of a block of the search: a fifth
  /// of a meter or so.
  std::optional<MapRegion> region;
};

/// A pose at which the points fit.
struct GlobalHypothesis {
  Pose2 pose;          ///< map_T_base
  double score = 0.0;  ///< mean likelihood of the points, 0 to 1; see kUnknownScore
};

/// Searches the whole map for the poses at which a scan fits, with every yaw. Best-first branch and
/// bound: what is left out cannot fit as well as `margin` below the best pose, on the grid of the
/// map. It can be interrupted at any time.
class GlobalSearch {
 public:
  /// `points`: in the base frame, m. `map` must outlive the search.
  GlobalSearch(const GlobalMap& map, const Points& points, const GlobalSearchConfig& config);
  ~GlobalSearch();
  GlobalSearch(GlobalSearch&&) noexcept;
  GlobalSearch& operator=(GlobalSearch&&) noexcept;

  /// Searches on until the budget is used. Returns whether the search has ended.
  bool run(WorkBudget& budget);
  bool isDone() const;
  /// False if there were too many candidates to look at all of them.
  bool isComplete() const;
  /// So far, best first, no two of them near each other.
  const std::vector<GlobalHypothesis>& hypotheses() const;
  std::size_t memoryBytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
