// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "kestrel_slam/graph/relocalizer.h"

namespace kestrel {

/// Finds a vehicle in a map while it moves: first by a single scan, then by all scans of the last
/// meters together. So the places that explain only some of the scans drop out, until one is left.
class PlaceFinder {
 public:
  /// `map` must outlive the object.
  PlaceFinder(const GlobalMap& map, const MatcherConfig& matcher,
              const RelocalizationConfig& config)
      : relocalizer_(map, matcher, config) {}

  /// The vehicle is in this region when the next scan is added, as far as can be told. The searches
  /// are limited to what it can have reached since then. If it is not found there, or has moved by
  /// some meters, the whole map is searched.
  void limitTo(const MapRegion& region) { limit_ = Limit{region, std::nullopt}; }

  /// Adds a scan. `local_T_base`: from odometry or from a map of the last scans only, in any
  /// continuous frame. Begins a search if none runs and the vehicle has moved since the last one.
  void add(const PlanarScan& scan, const Pose2& local_T_base);

  /// Searches on with so much work. Returns whether a search has ended.
  bool advance(std::int64_t work);

  /// What the last search said that has ended.
  const RelocalizationAnswer& answer() const { return answer_; }
  /// map_T_local if the vehicle was found.
  std::optional<Pose2> mapTLocal() const;
  /// Where the vehicle may be now (map_T_base), best first.
  std::vector<Pose2> hypotheses() const;
  /// Forgets all scans and the limit: the local frame has jumped.
  void reset();

  std::size_t memoryBytes() const;

 private:
  struct Part {
    Pose2 local_T_base;
    PlanarScan scan;
  };

  struct Limit {
    MapRegion region;
    std::optional<Pose2> local_T_base;  ///< of the scan to which the region belongs
  };

  std::optional<MapRegion> region(const Pose2& local_T_base) const;
  void keep(const PlanarScan& scan, const Pose2& local_T_base);
  RelocalizationQuery query(const PlanarScan& scan, const Pose2& local_T_base) const;

  Relocalizer relocalizer_;
  RelocalizationAnswer answer_;
  std::deque<Part> parts_;         ///< oldest first
  std::optional<Pose2> asked_;     ///< local_T_base of the search that runs or ran last
  std::optional<Pose2> answered_;  ///< local_T_base of `answer_`
  std::optional<Limit> limit_;
  bool is_limited_ = false;  ///< the search that runs or ran last
  bool search_all_ = false;  ///< it was limited, and nothing was found
  bool waiting_ = false;     ///< for the answer of the search that was begun last
  Pose2 last_;               ///< local_T_base of the last scan
};

}  // namespace kestrel
