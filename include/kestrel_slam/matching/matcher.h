// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/correlative.h"
#include "kestrel_slam/matching/gauss_newton.h"
#include "kestrel_slam/matching/icp.h"
#include "kestrel_slam/matching/match_result.h"
#include "kestrel_slam/matching/progressive.h"

namespace kestrel {

/// Parameters of all matchers.
struct MatcherConfig {
  /// gauss_newton (paper 001), correlative (paper 000), progressive (paper 002), icp (papers 003
  /// and 004) or hybrid
  std::string method = "hybrid";
  GaussNewtonConfig gauss_newton;
  CorrelativeConfig correlative;
  ProgressiveConfig progressive;
  IcpConfig icp;

  double score_scale_m = 0.1;  ///< a point this far from its wall fits by half
  double good_score = 0.9;     ///< below: the other initial guesses are tried as well
  double search_score = 0.8;   ///< below: the exhaustive search is tried as well
  double jump_margin = 0.05;   ///< by how much a found pose has to be better than the local one
  SearchWindow near_window{0.6, 0.52};
  SearchWindow wide_window{1.0, 1.57};  ///< where the near one finds nothing good
  std::string covariance = "hessian";   ///< or sampled: paper 001, IV-B; correlative has its own
  double degenerate_share = 0.015;      ///< smaller eigenvalue of the normals below which the scan
                                        ///< does not constrain a direction
};

/// One scan to be matched.
struct MatchRequest {
  const Points& points;
  Pose2 last;  ///< map_T_base of the scan before: small motions are penalized_score
  std::vector<Pose2> initial_guesses;  ///< predictions, best first; never empty
  bool search_all_round = false;       ///< nothing is known of the yaw (a gap, a lost state)
  double search_scale = 1.0;           ///< of the windows' linear size, for a longer absence
  bool turn_known = false;  ///< the yaw of the first initial guess is exact to some degrees
  bool trusted = false;     ///< the first initial guess is exact to some centimeters
  double plausible_m =
      1e9;            ///< a pose farther from the first initial guess has to fit that much better
  bool lost = false;  ///< the pose is only predicted: search the widest window
};

/// Aligns a scan with a map. Stateless: the same request gives the same result.
class Matcher {
 public:
  virtual ~Matcher() = default;
  virtual MatchResult match(const Submap& map, const MatchRequest& request) const = 0;
};

/// All methods that makeMatcher knows.
const std::vector<std::string>& matcherNames();

/// Throws std::invalid_argument for an unknown method.
std::unique_ptr<Matcher> makeMatcher(const MatcherConfig& config);

/// What the matcher needs of a map, beside the grid and the surface that all use.
SubmapOptions submapOptions(const MatcherConfig& config);

}  // namespace kestrel
