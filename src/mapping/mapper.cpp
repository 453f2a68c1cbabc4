// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/mapper.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "kestrel_slam/mapping/match_reason.h"
#include "kestrel_slam/matching/ambiguity.h"
#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/matching/thinned.h"
#include "kestrel_slam/sensor/projection.h"
#include "mapper_state.h"
#include "unobservable_motion.h"
#include "usable_scan.h"

namespace kestrel {
namespace {

/// At least this many points are matched, where a scan has more. The time of a match and of a
/// search is proportional to their number; more points add little accuracy. All are inserted.
constexpr std::size_t kMatchPoints = 1100;
/// Fewer than one out of this many beams are few.
constexpr std::size_t kMostBeams = 2;
/// If fewer than one out of this many beams have a hit, they may fit at several places, and the
/// prediction by an IMU is worth more.
constexpr std::size_t kFewHits = 2;
/// The match shows the errors of the odometry if this share of the points constrains the weakest
/// direction.
constexpr double kWellConstrained = 0.1;
/// The poses of so many inserted scans are remembered: a room, or some laps in a small one.
constexpr std::size_t kRememberedPoses = 300;

MotionCheck::Entry positionOf(const MatchResult& match, const PlanarScan& scan) {
  MotionCheck::Entry result{scan.time, match.pose.translation()};
  result.covariance = match.covariance.topLeftCorner<2, 2>();
  result.laser = scan.source;
  if (isWeak(match, PredictionSource::kVelocity)) result.weak = match.degenerate_direction;
  return result;
}

MatchWorth worthOf(const MapperResult& result) {
  if (result.state == MatchState::kLost) return MatchWorth::kNone;
  const bool is_clear =
      result.state == MatchState::kOk && result.match.constraint > kWellConstrained;
  return is_clear ? MatchWorth::kClear : MatchWorth::kMatched;
}

}  // namespace

/// Whether the scan has too few hits for a match: a few hits fit in many places. If they are most
/// of the beams, the laser has no more, and without another source they are better than nothing.
bool Mapper::State::isBlank(const Points& points, const PlanarScan& scan,
                            const std::optional<Pose2>& odom_T_base) const {
  if (points.empty()) return true;
  if (points.size() >= kMinBeamsToMatch) return false;
  const bool is_measured =
      motion.predictionSourceOf(scan, odom_T_base) != PredictionSource::kVelocity;
  return is_measured || points.size() * kMostBeams < scan.rays.size();
}

/// The first scan defines the map.
void Mapper::State::begin(MapperResult& result) {
  result.match.pose = motion.pose();
  result.match.covariance.setZero();
  result.match.score = result.match.known = 1.0;
  result.match.converged = true;
  result.state = MatchState::kOk;
  uncertainty.begin(motion.pose());
}

/// The pose is known. The fit only shows whether it agrees with the map. Without a pose the state
/// stays lost.
void Mapper::State::follow(const Points& points, const PlanarScan& scan,
                           const std::optional<Pose2>& map_T_base, MapperResult& result) {
  const bool first = map.scans() == 0;
  if (!map_T_base || (first && points.empty())) return;
  motion.move(*map_T_base, *map_T_base, false, scan);
  begin(result);
  if (first || points.empty()) return;
  const Fit fit = fitOf(map.current(), points, motion.pose(), config.matcher.score_scale_m);
  result.match.score = fit.score;
  result.match.known = fit.known;
  const bool contradicts =
      fit.known >= config.min_known_share && fit.score < config.matcher.search_score;
  if (contradicts) result.state = MatchState::kDegraded;
}

/// Compares match and prediction along the weakest direction.
void Mapper::State::compareAlong(const Points& points, const PlanarScan& scan,
                                 const Pose2& motion_prediction, PredictionSource source,
                                 const PredictionError& predicted, MatchResult& match) {
  const double seconds = motion.secondsSince(scan);
  const double moved = (motion.pose().inverse() * match.pose).distance();
  const AlongError error = uncertainty.alongError(match, seconds, moved, source);
  if (isWeak(match, source))
    return followAlong(points, seconds, motion_prediction, source, error, match);
  // Odometry may be wrong in the same way for a long time, and is compared with the graph.
  if (source != PredictionSource::kVelocity) return;
  const Eigen::Vector2d away = motion_prediction.translation() - match.pose.translation();
  checkAlong(map.current(), points, match.degenerate_direction.dot(away), predicted.position_m(),
             match);
}

/// Along a weak direction: the prediction, and what little the scan shows.
void Mapper::State::followAlong(const Points& points, double seconds,
                                const Pose2& motion_prediction, PredictionSource source,
                                const AlongError& error, MatchResult& match) {
  constexpr double kSigmas = 3.0;
  const double variance = error.covariance(0, 0);
  const bool unobservable = isUnobservable(match, source);
  const double matched_m = keepPredictionAlong(motion_prediction, match);
  AlongFit fit = fitAlong(map.current(), points, match.pose, weakMotionOf(match),
                          kSigmas * std::sqrt(variance), beamsOf(source));
  if (!unobservable) fit = combined(fit, matched_m);
  correctAlong(fit, variance, seconds, match);
  if (source == PredictionSource::kVelocity)
    motion.setGainAlong(match.degenerate_direction, error.speedGain());
}

/// Whether another pose explains the scan as well, where the match is far from the prediction or
/// the prediction says little.
void Mapper::State::lookForSecond(const MatchRequest& request, PredictionSource source,
                                  const PredictionError& error, MapperResult& result) const {
  const bool is_measured = source != PredictionSource::kVelocity;
  if (request.lost || request.wide) {
    if (result.state == MatchState::kLost) return;
    if (!secondExplanation(map.current(), request, result.match, config.matcher) &&
        (is_measured || laser_odometry.agrees(request, result.match)))
      return;
    result.match.ambiguous = true;
    result.state = request.lost ? MatchState::kLost : MatchState::kDegraded;
    return;
  }
  // The scan before shows a jump best: it needs no map, which may look the same elsewhere.
  if (is_measured ||
      !JumpCheck::isJump(request.initial_guesses.front(), result.match.pose, error) ||
      laser_odometry.agrees(request, result.match))
    return;
  result.match.ambiguous = true;
  result.state = MatchState::kLost;
}

void Mapper::State::match(const Points& points, const PlanarScan& scan,
                          const std::optional<Pose2>& odom_T_base, const PredictionError& error,
                          MapperResult& result) {
  MatchRequest request = motion.request(points, scan, odom_T_base);
  SharedSearch memory;
  request.memory = &memory;
  // What a finished map does not have stays unknown: it says that the vehicle may be elsewhere.
  request.near = request.near && !map.isFixed();
  const PredictionSource prediction_source = motion.predictionSourceOf(scan, odom_T_base);
  const std::optional<Pose2> motion_prediction =
      motion.motionPrediction(request, scan, odom_T_base);
  growDoubt(scan);
  result.match = matchInDoubt(request);
  if (motion_prediction)
    compareAlong(points, scan, *motion_prediction, prediction_source, error, result.match);
  result.match.impossible_motion = prediction_source == PredictionSource::kVelocity &&
                                   motion_check.isImpossible(positionOf(result.match, scan));
  compareWithInertia(scan, result.match);
  result.evaluation = evaluationFunction(result.match, config.evaluation);
  result.state = judge(result.match, request, error);
  lookForSecond(request, prediction_source, error, result);
  matchElsewhere(request, result);
  settle(motion.isOutOfReach(scan, odom_T_base), result);
  const bool lost = result.state == MatchState::kLost;
  if (lost) {
    motion_check.clear();
  } else {
    motion_check.add(positionOf(result.match, scan));
  }
  if (lost && laser_odometry.carry(scan, prediction_source, error, motion, uncertainty, result))
    return fillFit(points, result);
  if (lost && isCarried(scan, odom_T_base, error))
    return carryUnmatched(points, scan, odom_T_base, error, result);
  motion.learnOdometry(result.match.pose, odom_T_base, worthOf(result), result.reversed);
  const double moved = (motion.pose().inverse() * result.match.pose).distance();
  motion.move(result.match.pose, request.initial_guesses.front(), lost, scan);
  if (lost) {
    uncertainty.lose(motion.pose(), error);
  } else {
    uncertainty.update(map.current().surface(), points, result.match, motion.secondsSince(scan),
                       moved, prediction_source);
    if (doubt) uncertainty.doubt(*doubt);
  }
}

/// Only a scan that fits well enough is inserted [MAV SLAM 2013, eq. 4-5].
void Mapper::State::insert(const PlanarScan& scan, bool has_odometry, MapperResult& result) {
  if (map.isFixed()) return;
  const bool first = map.scans() == 0;
  const bool new_space = result.carried && result.match.known < config.min_known_share;
  const bool accepted = !config.evaluation.enabled || first || new_space ||
                        result.evaluation < config.evaluation.threshold;
  const bool known_pose =
      result.state != MatchState::kLost && (!result.carried || has_odometry || result.followed);
  const bool moved = first || map.lacks(scan.source) || movedEnough();
  if (!known_pose || !accepted || !moved || isRepeated(result)) return;
  if (doubt && contradictsMap(result.match)) return;
  // Without an IMU the laser is level and always sees the same slice: a new object is moving or was
  // moved, and is not a new view.
  const bool new_view =
      scan.integrated_acceleration && result.match.score < config.matcher.good_score;
  map.insert(scan, motion.pose(), new_view, result.match.degenerate);
  result.inserted = true;
  result.new_view = new_view;
  result.submap = map.submap();
  inserted_poses.push_back(motion.pose());
  if (inserted_poses.size() > kRememberedPoses) inserted_poses.pop_front();
  if (!first) {
    result.keyframe_covariance = uncertainty.motionSince(inserted_pose);
    result.lasting_covariance = uncertainty.lastingSince(inserted_pose);
  }
  uncertainty.insert();
  inserted_pose = uncertainty.last();
}

/// Whether enough of the last inserted scans are from here, and this one shows nothing new. A
/// vehicle that hovers for an hour does not make the graph larger.
bool Mapper::State::isRepeated(const MapperResult& result) const {
  constexpr std::ptrdiff_t kEnoughScans = 3;
  constexpr double kAllKnown = 0.95;
  if (!config.usesGraph() || result.state != MatchState::kOk || result.match.known < kAllKnown ||
      result.match.score < config.matcher.good_score)
    return false;
  const auto is_here = [&](const Pose2& pose) {
    const Pose2 moved = pose.between(motion.pose());
    return moved.distance() < config.insert_distance_m &&
           std::abs(moved.yaw) < config.insert_angle_rad;
  };
  return std::count_if(inserted_poses.begin(), inserted_poses.end(), is_here) >= kEnoughScans;
}

/// Along an unobservable direction the vehicle may have moved although its pose did not. What it
/// sees then must be in the map before it is passed.
bool Mapper::State::movedEnough() const {
  const Pose2 moved = inserted_pose.pose.inverse() * motion.pose();
  return moved.distance() >= config.insert_distance_m ||
         uncertainty.driftSinceInsertion() >= config.insert_distance_m ||
         std::abs(moved.yaw) >= config.insert_angle_rad;
}

Mapper::Mapper(const MapperConfig& config) : state_(std::make_unique<State>(config)) {}
Mapper::Mapper(const MapperConfig& config, Submap map)
    : state_(std::make_unique<State>(config, std::move(map))) {}
Mapper::~Mapper() = default;
Mapper::Mapper(Mapper&&) noexcept = default;
Mapper& Mapper::operator=(Mapper&&) noexcept = default;

MapperResult Mapper::process(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) {
  if (!isUsable(scan)) return process(repaired(scan, state_->motion.time()), odom_T_base);
  if (odom_T_base && !isUsable(*odom_T_base)) return process(scan);
  State& s = *state_;
  MapperResult result;
  result.odom_T_base = odom_T_base;
  const Points points = thinned(hitsOf(scan), kMatchPoints);
  const PredictionError error = s.motion.errorAt(scan, odom_T_base);
  result.blank = s.isBlank(points, scan, odom_T_base);
  s.few_hits = scan.integrated_acceleration && hitsOf(scan).size() * kFewHits < scan.rays.size();
  if (s.config.known_poses) {
    s.follow(points, scan, odom_T_base, result);
  } else if (s.map.scans() > 0) {
    if (result.blank) {
      s.carry(scan, odom_T_base, error, result);
    } else {
      s.match(points, scan, odom_T_base, error, result);
    }
  } else if (!points.empty()) {
    s.begin(result);
  }
  s.insert(scan, s.motion.predictionSourceOf(scan, odom_T_base) == PredictionSource::kOdometry,
           result);
  result.reversed = s.motion.isReversed();
  result.map_full = s.map.current().isFull();
  s.motion.remember(scan, odom_T_base, s.laser_odometry.errorAfter(result, error));
  s.laser_odometry.update(scan, result, s.motion.pose());
  s.updateInertia(scan, result);
  result.pose = s.motion.pose();
  result.velocity = Eigen::Rotation2Dd(-result.pose.yaw) * s.motion.velocity();
  result.yaw_rate = s.motion.yawRate();
  result.uncertain = s.uncertainty.last();
  result.covariance = result.uncertain.covariance();
  result.motion_covariance = s.uncertainty.motion();
  result.searched = result.match.searched;
  result.reason = reasonOf(result, s.config);
  return result;
}

void Mapper::configure(const MapperConfig& config) {
  state_->config = config;
  state_->matcher = makeMatcher(config.matcher);
}

void Mapper::reset(const Pose2& map_T_base) {
  if (!isUsable(map_T_base)) return;
  if (state_->map.isFixed()) return setPose(map_T_base);
  const MapperConfig config = state_->config;
  state_ = std::make_unique<State>(config, map_T_base);
}

const Pose2& Mapper::pose() const { return state_->motion.pose(); }
const MapperConfig& Mapper::config() const { return state_->config; }
const Submap& Mapper::map() const { return state_->map.current(); }
MapSnapshot Mapper::snapshot() const { return state_->map.current().grid().snapshot(); }
bool Mapper::takeChangedTiles(std::size_t max_tiles, std::vector<TileImage>& images) {
  return state_->map.current().grid().takeChangedTiles(max_tiles, images);
}
std::size_t Mapper::memoryBytes() const {
  return state_->map.memoryBytes() + state_->laser_odometry.memoryBytes();
}

}  // namespace kestrel
