// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/localizer.h"

#include <algorithm>
#include <utility>

namespace kestrel {
namespace {

/// If no scan has fitted well for so long, the whole map is searched, too; and the vehicle is lost
/// if then a scan does not fit at all, s.
constexpr double kDoubtAfter = 0.3, kLostAfter = 0.7;
/// A scan fits if this share of it is in the known part of the map, and if it fits there.
constexpr double kFitScore = 0.5, kFitKnown = 0.3;
/// Work of the search for each second between two scans, and its limits for one scan.
constexpr double kWorkPerSecond = 5e8;
constexpr std::int64_t kLeastWork = 2'000'000, kMostWork = 80'000'000;
/// The match of the current scan must confirm the pose that was found, m.
constexpr double kConfirmM = 0.5;
/// A pose that was found in a smaller map is checked for so long, m.
constexpr double kCheckM = 5.0;
/// Standard deviations of an unknown pose.
constexpr double kUnknownM = 100.0, kUnknownRad = 2.0;

MapperConfig localConfig(MapperConfig config, const Submap& map) {
  config.grid.resolution_m = static_cast<double>(map.grid().resolution());
  config.window.enabled = true;
  return config;
}

MapperConfig fixedConfig(MapperConfig config) {
  config.window.enabled = false;
  return config;
}

bool fits(const MapperResult& result, double least_score = kFitScore) {
  return result.isMatched() && result.match.score >= least_score && result.match.known >= kFitKnown;
}

}  // namespace

Localizer::Localizer(const MapperConfig& config, Submap map,
                     const RelocalizationConfig& relocalization)
    : local_config_(localConfig(config, map)),
      tracker_(fixedConfig(local_config_), std::move(map)),
      global_(tracker_.map()),
      finder_(global_, config.matcher, relocalization),
      min_fit_(relocalization.min_fit) {}

MapperResult Localizer::process(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) {
  // A search near the prediction could find an equal room.
  if (!lost_ && tracker_.isAfterGap(scan, odom_T_base)) {
    const MapRegion region{tracker_.pose().translation(), tracker_.reach(scan, odom_T_base)};
    lose(tracker_.pose());
    finder_.limitTo(region);
    tracker_.learnInterval(secondsSince(scan));
  }
  MapperResult result = lost_ ? search(scan, odom_T_base) : track(scan, odom_T_base);
  time_ = scan.time;
  return result;
}

MapperResult Localizer::track(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) {
  MapperResult result = tracker_.process(scan, odom_T_base);
  const bool good = result.isMatched() && result.match.score >= local_config_.matcher.search_score;
  // Without anything to see, the odometry knows the pose.
  if (!fit_time_ || good || (result.blank && result.state != MatchState::kLost)) {
    fit_time_ = scan.time;
    if (mustCheck(result.pose)) return result.blank ? result : doubt(scan, odom_T_base, result);
    check_from_.reset();
    finder_.reset();
    return result;
  }
  const double doubtful_s = scan.time - *fit_time_;
  if (doubtful_s > kLostAfter && !fits(result)) {
    lose(result.pose);
    return search(scan, odom_T_base);
  }
  if (doubtful_s > kDoubtAfter) return doubt(scan, odom_T_base, result);
  return result;
}

/// A pose from a smaller map may be that of a place which looks alike.
bool Localizer::mustCheck(const Pose2& map_T_base) const {
  return check_from_ && check_from_->between(map_T_base).distance() <= kCheckM;
}

/// People or moved furniture, or the vehicle is somewhere else: the whole map is searched while the
/// matching goes on.
MapperResult Localizer::doubt(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                              const MapperResult& result) {
  finder_.add(scan, result.pose);
  finder_.advance(workFor(scan));
  const std::optional<Pose2> correction = finder_.mapTLocal();
  if (!correction) return result;
  const Pose2 found = *correction * result.pose;
  finder_.reset();
  if (result.pose.between(found).distance() <= kConfirmM) {
    fit_time_ = scan.time;
    check_from_.reset();
    return result;
  }
  if (const auto confirmed = confirm(scan, odom_T_base, found)) return *confirmed;
  tracker_.setPose(result.pose);
  return result;
}

/// The work of a search for one scan.
std::int64_t Localizer::workFor(const PlanarScan& scan) const {
  return std::clamp(static_cast<std::int64_t>(kWorkPerSecond * secondsSince(scan)), kLeastWork,
                    kMostWork);
}

double Localizer::secondsSince(const PlanarScan& scan) const {
  return time_ ? scan.time - *time_ : 0.0;
}

MapperResult Localizer::search(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) {
  if (local_ && local_->isAfterGap(scan, odom_T_base)) {
    beginAnew(local_->pose());
    tracker_.learnInterval(secondsSince(scan));
  }
  if (!local_) {
    local_ = std::make_unique<Mapper>(local_config_);
    local_->takeMotion(tracker_, scan, odom_T_base);
  }
  MapperResult result = local_->process(scan, odom_T_base);
  if (result.state == MatchState::kLost) {
    beginAnew(result.pose);
  } else if (!result.blank) {
    finder_.add(scan, result.pose);
    finder_.advance(workFor(scan));
    if (const std::optional<Pose2> map_T_local = finder_.mapTLocal()) {
      if (const auto found = confirm(scan, odom_T_base, *map_T_local * result.pose)) return *found;
      finder_.reset();
    }
  }
  result.pose = local_ ? guess_ * result.pose : guess_;
  result.state = MatchState::kLost;
  result.reason = "the pose in the map is unknown";
  result.carried = true;
  result.inserted = false;
  result.covariance = Eigen::Vector3d(kUnknownM, kUnknownM, kUnknownRad).cwiseAbs2().asDiagonal();
  result.uncertain = {result.pose, result.covariance, Eigen::Matrix3d::Zero()};
  result.motion_covariance = result.covariance;
  return result;
}

/// The motion in the map of the last scans is unknown, too.
void Localizer::beginAnew(const Pose2& local_T_base) {
  guess_ = guess_ * local_T_base;
  tracker_.takeInterval(*local_);
  local_.reset();
  finder_.reset();
}

/// The search began some scans ago: the current scan must fit as well as its scans did.
std::optional<MapperResult> Localizer::confirm(const PlanarScan& scan,
                                               const std::optional<Pose2>& odom_T_base,
                                               const Pose2& pose) {
  tracker_.setFoundPose(pose, local_ ? *local_ : tracker_);
  const MapperResult result = tracker_.process(scan, odom_T_base);
  if (!fits(result, min_fit_) || result.pose.between(pose).distance() > kConfirmM)
    return std::nullopt;
  lost_ = false;
  fit_time_ = scan.time;
  check_from_.reset();
  // No time passed between both matches of this scan, so the second one has no speed.
  if (local_) tracker_.setFoundPose(result.pose, *local_);
  local_.reset();
  finder_.reset();
  return result;
}

void Localizer::lose(const Pose2& map_T_base) {
  lost_ = true;
  check_from_.reset();
  guess_ = map_T_base;
  local_.reset();
  finder_.reset();
}

void Localizer::setPose(const Pose2& map_T_base) {
  tracker_.setPose(map_T_base);
  lost_ = false;
  fit_time_.reset();
  check_from_.reset();
  local_.reset();
  finder_.reset();
}

void Localizer::continueFrom(const Localizer& before, const Pose2& after_T_before) {
  tracker_.takeInterval(before.tracker_);
  if (before.lost_) return;
  const Pose2 pose = after_T_before * before.tracker_.pose();
  setPose(pose);
  tracker_.setFoundPose(pose, before.tracker_);
  check_from_ = pose;
  time_ = before.time_;
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
