// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "kestrel_slam/geometry/pose_covariance.h"
#include "kestrel_slam/graph/wall_agreement.h"
#include "kestrel_slam/matching/global_search.h"
#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// Parameters of the relocalization. All defaults are defined here.
struct RelocalizationConfig {
  double min_fit = 0.65;         ///< fit of the scan where the map is known, 0 to 1
  double min_known = 0.6;        ///< share of the scan in the known part of the map
  double min_constraint = 0.02;  ///< share of the scan that constrains the weakest direction
  double min_margin = 0.1;       ///< by which the score is at least better than at any other place
  double max_contradiction = 0.31;  ///< share of the walls, see WallAgreement::contradictionBound
  double min_agreement = 0.7;       ///< share of the single scans that fit at the same place
  std::int64_t most_work = 1'500'000'000;  ///< of one search, see WorkBudget
};

/// A scan, or several that are matched together, and how they lie relative to each other.
struct RelocalizationQuery {
  struct Part {
    Pose2 base_T_scan;  ///< in the frame of the base where the query asks for its pose
    PlanarScan scan;
  };
  std::vector<Part> parts;
  /// The vehicle is in this part of the map; what fits elsewhere is no explanation. None: anywhere.
  std::optional<MapRegion> region = std::nullopt;
};

/// A pose where the vehicle may be.
struct PlaceHypothesis {
  MatchResult match;
  WallAgreement walls;
  double score() const { return walls.score(); }
};

enum class RelocalizationState {
  kSearching,
  kFound,
  kAmbiguous,  ///< the scan fits in several places
  kUnknown     ///< it fits nowhere, or it shows too little
};

const char* toString(RelocalizationState state);

struct RelocalizationAnswer {
  RelocalizationState state = RelocalizationState::kSearching;
  const char* reason = "";                  ///< why it is ambiguous or unknown
  std::vector<PlaceHypothesis> hypotheses;  ///< best first; if found, the first is the place
  double agreement = 1.0;                   ///< share of the single scans
  double margin = 0.0;                      ///< from the first to the second
  std::int64_t work = 0;                    ///< that was needed, see WorkBudget

  GaussianPose2 pose() const;  ///< map_T_base of the first hypothesis
};

/// Finds the pose of a vehicle in the whole map when nothing is known about it.
///
/// Never guesses: if a second place explains the scan nearly as well, the answer is ambiguous, and
/// if the best place does not explain it, unknown.
class Relocalizer {
 public:
  /// `map` must outlive the object.
  Relocalizer(const GlobalMap& map, const MatcherConfig& matcher,
              const RelocalizationConfig& config);

  /// Begins a search. One that has not ended is given up.
  void begin(RelocalizationQuery query);
  /// Whether a search was begun that has not ended.
  bool isSearching() const { return search_.has_value(); }
  /// Searches on with so much work. The state of the answer is kSearching until the search ends.
  const RelocalizationAnswer& advance(std::int64_t work);
  const RelocalizationAnswer& answer() const { return answer_; }

  /// Begins a search and completes it.
  const RelocalizationAnswer& locate(RelocalizationQuery query);

  std::size_t memoryBytes() const;

 private:
  void conclude(bool complete);
  void rank();
  void judge(bool complete);
  double neededMargin() const;
  double agreementAt(const MatchResult& found) const;
  PlaceHypothesis hypothesisAt(const Pose2& guess) const;
  WallAgreement wallsAt(const Pose2& map_T_base) const;
  const char* problemOf(const PlaceHypothesis& hypothesis) const;

  const GlobalMap& map_;
  MatcherConfig matcher_;
  RelocalizationConfig config_;
  RelocalizationQuery query_;
  Points points_;  ///< of the query
  std::optional<GlobalSearch> search_;
  RelocalizationAnswer answer_;
};

}  // namespace kestrel
