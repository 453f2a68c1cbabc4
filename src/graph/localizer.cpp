// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/localizer.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/matching/place_match.h"
#include "kestrel_slam/matching/thinned.h"

namespace kestrel {
namespace {

/// If the map contradicts the pose for so long, the whole map is searched, too; and then the
/// vehicle is lost, s. It may have been carried away. If the scans show its whole motion, the place
/// has rather changed since it was mapped, and it is lost later.
constexpr double kDoubtAfter = 0.3, kLostAfter = 0.7, kLostAfterMotion = 5.0;
/// A scan fits if this share of it is in the known part of the map, and if it fits there. It fits
/// clearly if half of it is in the known part, and if no search was needed. It corrects the motion
/// if half of it is on walls of the map.
constexpr double kFitScore = 0.5, kFitKnown = 0.3, kClearKnown = 0.5, kOnWalls = 0.5;
/// The map corrects the pose of a vehicle that is followed by so many standard deviations of the
/// motion, and the errors of two matches.
constexpr double kSigmas = 3.0, kMatchM = 0.06, kMatchRad = 0.03;
/// With a larger error of the motion the pose is searched, and is unknown, m.
constexpr double kDoubtM = 0.5, kUnknownAfterM = 2.0;
constexpr std::size_t kPoints = 720;
/// Work of the search for each second between two scans, and its limits for one scan.
constexpr double kWorkPerSecond = 4e8;
constexpr std::int64_t kLeastWork = 2'000'000, kMostWork = 50'000'000;
/// The match of the current scan must confirm the pose that was found, m.
constexpr double kConfirmM = 0.5;
/// Standard deviations of an unknown pose.
constexpr double kUnknownM = 100.0, kUnknownRad = 2.0;

MapperConfig localConfig(MapperConfig config, const Submap& map) {
  config.grid.resolution_m = static_cast<double>(map.grid().resolution());
  config.window.enabled = true;
  return config;
}

/// The localizer itself follows the motion where a scan does not fit.
MapperConfig fixedConfig(MapperConfig config) {
  config.window.enabled = false;
  config.laser_odometry = false;
  return config;
}

bool fits(const MapperResult& result) {
  return result.isMatched() && result.match.score >= kFitScore && result.match.known >= kFitKnown;
}

bool isFree(const OccupancyGrid& grid, const Eigen::Vector2f& at) {
  const Cell cell = grid.cellAt(at);
  return grid.isKnown(cell) && !grid.isOccupied(cell);
}

double positionSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> position(covariance.topLeftCorner<2, 2>(),
                                                                Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, position.eigenvalues()(1)));
}

/// Whether a match is where the motion leads to. Along an unobservable direction it says nothing.
bool agrees(const MatchResult& match, const GaussianPose2& motion) {
  Eigen::Vector2d away = match.pose.translation() - motion.mean.translation();
  if (match.degenerate) away -= match.degenerate_direction * match.degenerate_direction.dot(away);
  const double turn = std::abs(normalizeAngle(match.pose.yaw - motion.mean.yaw));
  return away.norm() <= kMatchM + kSigmas * positionSigma(motion.covariance) &&
         turn <= kMatchRad + kSigmas * std::sqrt(std::max(0.0, motion.covariance(2, 2)));
}

}  // namespace

Localizer::Localizer(const MapperConfig& config, Submap map,
                     const RelocalizationConfig& relocalization)
    : local_config_(localConfig(config, map)),
      tracker_(fixedConfig(local_config_), std::move(map)),
      global_(tracker_.map()),
      finder_(global_, config.matcher, relocalization) {}

MapperResult Localizer::process(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) {
  MapperResult result = lost_    ? search(scan, odom_T_base)
                        : local_ ? follow(scan, odom_T_base)
                                 : track(scan, odom_T_base);
  time_ = scan.time;
  return result;
}

MapperResult Localizer::track(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) {
  const MapperResult result = tracker_.process(scan, odom_T_base);
  // Without anything to see, the odometry knows the pose.
  if (result.blank && result.state != MatchState::kLost) {
    fit_time_ = scan.time;
    return result;
  }
  const bool after_gap = time_ && scan.time - *time_ > local_config_.gap_s;
  if (isClear(result) || !last_scan_ || (after_gap && fits(result))) {
    remember(scan, odom_T_base, result);
    return result;
  }
  beginLocalMap();
  return follow(scan, odom_T_base);
}

/// Where the known part of a scan is small, or where the match had to be searched for, it may be at
/// a wrong place although it fits.
bool Localizer::isClear(const MapperResult& result) const {
  return result.isMatched() && !result.searched && result.match.known >= kClearKnown &&
         result.match.score >= local_config_.matcher.search_score;
}

void Localizer::remember(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                         const MapperResult& result) {
  last_scan_ = scan;
  last_odometry_ = odom_T_base;
  known_.in_map = result.uncertain;
  known_.in_map.pose = result.pose;
  fit_time_ = scan.time;
}

/// The local map begins with the last scan whose pose in the map is known.
void Localizer::beginLocalMap() {
  local_ = std::make_unique<Mapper>(local_config_);
  known_.in_local = local_->process(*last_scan_, last_odometry_).uncertain;
  motion_known_ = true;
}

/// map_T_base by the motion since the pose was known. The covariance is that of the motion.
GaussianPose2 Localizer::predicted(const MapperResult& local) const {
  return {known_.in_map.pose * known_.in_local.pose.between(local.pose),
          relativeCovariance(known_.in_local, local.uncertain)};
}

/// Whether a scan fits to those before it.
bool Localizer::showsMotion(const MapperResult& local) const {
  return local.isMatched() && !local.match.ambiguous && local.match.known >= kFitKnown &&
         local.match.score >= local_config_.matcher.search_score;
}

MapperResult Localizer::follow(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) {
  const MapperResult local = local_->process(scan, odom_T_base);
  motion_known_ &= showsMotion(local);
  MapperResult result = local;
  compare(scan, local, result);
  if (!result.carried) {
    if (const auto tracked = returnToMap(scan, odom_T_base, result)) return *tracked;
  }
  const double doubtful_s = scan.time - *fit_time_;
  const double sigma = positionSigma(result.covariance);
  if (doubtful_s > (motion_known_ ? kLostAfterMotion : kLostAfter) || sigma > kUnknownAfterM) {
    lose(result.pose);
    return search(scan, odom_T_base);
  }
  if (doubtful_s <= kDoubtAfter && sigma <= kDoubtM) {
    finder_.reset();
  } else if (!local.blank && local.state != MatchState::kLost) {
    if (const auto found = searchWhileFollowing(scan, odom_T_base, result)) return *found;
  }
  tracker_.setPose(result.pose);
  return result;
}

/// The pose by the motion, or by the map where it agrees with the motion.
void Localizer::compare(const PlanarScan& scan, const MapperResult& local, MapperResult& result) {
  const GaussianPose2 motion = predicted(local);
  result.pose = motion.mean;
  result.state = MatchState::kDegraded;
  result.followed = result.carried = true;
  result.inserted = result.new_view = false;
  result.submap = 0;
  result.reason = local.state == MatchState::kLost ? "carried: no fit" : "carried: not in the map";
  if (!local.blank && local.state != MatchState::kLost) {
    result.match = matchNear(tracker_.map(), sampled(hitsOf(scan), kPoints), motion.mean,
                             local_config_.matcher);
    const bool fitting = result.match.score * result.match.known >= kOnWalls;
    const bool elsewhere = fitting && result.match.score >= local_config_.matcher.search_score;
    if (fitting && agrees(result.match, motion)) {
      result.pose = result.match.pose;
      result.carried = false;
      motion_known_ = true;
      result.reason = "poor fit";
      known_ = {{result.pose, result.match.covariance, Eigen::Matrix3d::Zero()}, local.uncertain};
      result.covariance = result.match.covariance;
    }
    // If the motion is unknown, too, only a fit shows that the pose is right.
    if (!result.carried || (motion_known_ && !elsewhere && !contradicts(scan, motion.mean)))
      fit_time_ = scan.time;
  }
  if (result.carried) {
    result.covariance = transported(known_.in_map.covariance(),
                                    result.pose.translation() - known_.in_map.pose.translation()) +
                        rotated(motion.covariance, known_.in_map.pose.yaw);
  }
  result.uncertain = {result.pose, result.covariance, Eigen::Matrix3d::Zero()};
}

/// Whether more of the scan is in space that the map shows as free than on its walls. Space that
/// the map only presumes to be free says nothing.
bool Localizer::contradicts(const PlanarScan& scan, const Pose2& map_T_base) const {
  std::size_t on_walls = 0, in_free_space = 0;
  const Submap& map = tracker_.map();
  const auto near = static_cast<float>(2.0 * local_config_.matcher.score_scale_m);
  for (const Eigen::Vector2f& hit : sampled(hitsOf(scan), kPoints)) {
    const Eigen::Vector2f at = (map_T_base * hit.cast<double>()).cast<float>();
    const Surfel* wall = map.surface().nearest(at);
    if (wall != nullptr && (wall->mean - at).norm() < near) {
      ++on_walls;
    } else if (isFree(map.grid(), at)) {
      ++in_free_space;
    }
  }
  return in_free_space > on_walls;
}

/// The scan fits clearly again: it is tracked from here.
std::optional<MapperResult> Localizer::returnToMap(const PlanarScan& scan,
                                                   const std::optional<Pose2>& odom_T_base,
                                                   const MapperResult& result) {
  if (result.match.score < local_config_.matcher.search_score) return std::nullopt;
  tracker_.setPose(result.pose);
  const MapperResult tracked = tracker_.process(scan, odom_T_base);
  if (!fits(tracked) || tracked.pose.between(result.pose).distance() > kMatchM) return std::nullopt;
  local_.reset();
  finder_.reset();
  remember(scan, odom_T_base, tracked);
  return tracked;
}

/// People or moved furniture, or the vehicle is somewhere else: the whole map is searched while the
/// vehicle is followed.
std::optional<MapperResult> Localizer::searchWhileFollowing(const PlanarScan& scan,
                                                            const std::optional<Pose2>& odom_T_base,
                                                            const MapperResult& result) {
  finder_.add(scan, result.pose);
  finder_.advance(workFor(scan));
  const std::optional<Pose2> correction = finder_.mapTLocal();
  if (!correction) return std::nullopt;
  finder_.reset();
  return confirm(scan, odom_T_base, *correction * result.pose);
}

/// The work of a search for one scan.
std::int64_t Localizer::workFor(const PlanarScan& scan) const {
  const double seconds = time_ ? scan.time - *time_ : 0.0;
  return std::clamp(static_cast<std::int64_t>(kWorkPerSecond * seconds), kLeastWork, kMostWork);
}

MapperResult Localizer::search(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) {
  if (!local_) local_ = std::make_unique<Mapper>(local_config_);
  MapperResult result = local_->process(scan, odom_T_base);
  if (result.state == MatchState::kLost) {
    // The motion is unknown, too: begin anew.
    lose(predicted(result).mean);
  } else if (!result.blank) {
    finder_.add(scan, result.pose);
    finder_.advance(workFor(scan));
    if (const std::optional<Pose2> map_T_local = finder_.mapTLocal()) {
      if (const auto found = confirm(scan, odom_T_base, *map_T_local * result.pose)) return *found;
      finder_.reset();
    }
  }
  result.pose = local_ ? predicted(result).mean : known_.in_map.pose;
  return unknownPose(std::move(result));
}

MapperResult Localizer::unknownPose(MapperResult result) const {
  result.state = MatchState::kLost;
  result.reason = "the pose in the map is unknown";
  result.carried = true;
  result.inserted = false;
  result.covariance = Eigen::Vector3d(kUnknownM, kUnknownM, kUnknownRad).cwiseAbs2().asDiagonal();
  result.uncertain = {result.pose, result.covariance, Eigen::Matrix3d::Zero()};
  result.motion_covariance = result.covariance;
  return result;
}

/// The search began some scans ago: the current scan must fit as well.
std::optional<MapperResult> Localizer::confirm(const PlanarScan& scan,
                                               const std::optional<Pose2>& odom_T_base,
                                               const Pose2& pose) {
  tracker_.setPose(pose);
  const MapperResult result = tracker_.process(scan, odom_T_base);
  if (!fits(result) || result.pose.between(pose).distance() > kConfirmM) return std::nullopt;
  lost_ = false;
  local_.reset();
  finder_.reset();
  remember(scan, odom_T_base, result);
  return result;
}

void Localizer::lose(const Pose2& map_T_base) {
  lost_ = true;
  known_ = {{map_T_base, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()}, UncertainPose()};
  last_scan_.reset();
  local_.reset();
  finder_.reset();
}

void Localizer::setPose(const Pose2& map_T_base) {
  lose(map_T_base);
  tracker_.setPose(map_T_base);
  lost_ = false;
  fit_time_.reset();
}

void Localizer::relocalize() { lose(tracker_.pose()); }

void Localizer::restartMotion() {
  const Pose2 pose = tracker_.pose();  // copy: setPose changes the value behind pose()
  if (lost_) {
    lose(pose);
  } else {
    setPose(pose);
  }
}

std::size_t Localizer::memoryBytes() const {
  return tracker_.memoryBytes() + finder_.memoryBytes() + (local_ ? local_->memoryBytes() : 0);
}

}  // namespace kestrel
