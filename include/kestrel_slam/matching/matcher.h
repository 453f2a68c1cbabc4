#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/correlative.h"
#include "kestrel_slam/matching/gauss_newton.h"
#include "kestrel_slam/matching/match_result.h"

namespace kestrel_slam {

/// Parameters of all matchers.
struct MatcherConfig {
  std::string method = "hybrid";  ///< gauss_newton (paper 001), correlative (paper 000) or hybrid
  GaussNewtonConfig gauss_newton;
  CorrelativeConfig correlative;

  double score_scale_m = 0.1;  ///< a point this far from its wall fits by half
  double good_score = 0.9;     ///< below: the other starts are tried as well
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
  Pose2 last;                     ///< map_T_base of the scan before: small motions are preferred
  std::vector<Pose2> starts;      ///< predictions, best first; never empty
  bool search_all_round = false;  ///< nothing is known of the heading (a gap, a lost state)
  double search_scale = 1.0;      ///< of the windows' linear size, for a longer absence
  bool turn_known = false;        ///< the heading of the first start is exact to some degrees
  bool trusted = false;           ///< the first start is exact to some centimetres
  double plausible_m = 1e9;  ///< a pose farther from the first start has to fit that much better
};

/// Aligns a scan with a map. Stateless: the same request gives the same result.
class Matcher {
 public:
  virtual ~Matcher() = default;
  virtual MatchResult match(const Submap& map, const MatchRequest& request) const = 0;
};

/// Throws std::invalid_argument for an unknown method.
std::unique_ptr<Matcher> makeMatcher(const MatcherConfig& config);

}  // namespace kestrel_slam
