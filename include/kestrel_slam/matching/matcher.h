// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/correlative.h"
#include "kestrel_slam/matching/gauss_newton.h"
#include "kestrel_slam/matching/icp.h"
#include "kestrel_slam/matching/match_result.h"
#include "kestrel_slam/matching/progressive.h"
#include "kestrel_slam/matching/shared_search.h"

namespace kestrel {

/// Parameters of all matchers.
struct MatcherConfig {
  /// gauss_newton [Kohlbrecher 2011], correlative [MAV SLAM 2013], progressive [Xie 2010], icp
  /// [Siew 2018; multi-robot ICP] or hybrid
  std::string method = "hybrid";
  GaussNewtonConfig gauss_newton;
  CorrelativeConfig correlative;
  ProgressiveConfig progressive;
  IcpConfig icp;

  double score_scale_m = 0.1;  ///< a point at this distance from its wall fits by half
  double good_score = 0.9;     ///< below this score the other initial guesses are tried
  double search_score = 0.8;   ///< below this score the exhaustive search is run
  double jump_margin = 0.05;   ///< minimum increase of the score to accept a pose of the search
  SearchWindow near_window{0.6, 0.52};
  SearchWindow wide_window{1.0, 1.57};  ///< used if the search in the near window fails
  /// Hessian or sampled [Kohlbrecher 2011, sec. IV-B]; correlative has its own.
  std::string covariance = "hessian";
  /// A direction is unobservable if a smaller share of the beams shows it (see WeakMotion).
  double degenerate_share = 0.007;
};

/// A prediction of the pose from measured motion.
struct MotionPrior {
  Pose2 pose;              ///< map_T_base
  double sigma_m = 0.0;    ///< standard deviation along x and along y
  double sigma_rad = 0.0;  ///< standard deviation of the yaw

  /// Squared distance of `other`, in standard deviations.
  double chi2(const Pose2& other) const;
  /// Whether `other` is within three standard deviations.
  bool isPlausible(const Pose2& other) const;
};

/// A scan to match.
struct MatchRequest {
  const Points& points;
  Pose2 last;  ///< map_T_base of the previous scan; the motion from it is penalized
  std::vector<Pose2> initial_guesses;  ///< predicted poses, best first; never empty
  bool search_all_yaws = false;        ///< the yaw is unknown (after a gap, or lost)
  double search_scale = 1.0;   ///< factor of the linear size of the windows, for a longer gap
  double turned_back_m = 0.0;  ///< a vehicle that turned back is this far from the first guess;
                               ///< there it must fit well
  double moved_scale = 1.0;    ///< divides the penalty of the motion, if it may be large
  bool yaw_known = false;      ///< the yaw of the first initial guess is accurate to some degrees,
  double yaw_error_rad = 0.0;  ///< or to this, if it is larger
  /// The pose is so close to the first initial guess that a hit in unknown space, past the end of a
  /// wall, is rather something new than this wall.
  bool near = false;
  bool trusted = false;      ///< the first initial guess is accurate to some centimeters
  double plausible_m = 1e9;  ///< a pose farther than this from the first initial guess needs a
                             ///< larger increase of the score, proportional to the distance
  std::optional<MotionPrior> prior =
      std::nullopt;    ///< of the odometry: the distance from it is penalized
  bool wide = false;   ///< the local match may not find the pose: search the near window
  bool lost = false;   ///< the last poses were only predicted: search the widest window
  int lost_scans = 0;  ///< number of consecutive lost scans before this one
  SharedSearch* memory = nullptr;  ///< of this scan, shared by its searches
};

/// Aligns a scan with a map. Has no state: equal requests give equal results.
class Matcher {
 public:
  virtual ~Matcher() = default;
  virtual MatchResult match(const Submap& map, const MatchRequest& request) const = 0;
};

/// The names of all methods.
const std::vector<std::string>& matcherNames();

/// Creates a matcher. Throws std::invalid_argument if the method is unknown.
std::unique_ptr<Matcher> makeMatcher(const MatcherConfig& config);

/// Options of a submap that the matcher needs.
SubmapOptions submapOptions(const MatcherConfig& config);

}  // namespace kestrel
