// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/laser_odometry.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/symmetric_axes.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/mapping/motion_model.h"
#include "kestrel_slam/matching/ambiguity.h"
#include "kestrel_slam/matching/matcher.h"

namespace kestrel {
namespace {

MotionError errorOf(const Eigen::Matrix3d& covariance) {
  const SymmetricAxes<2> position =
      symmetricAxes(Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()));
  return {std::sqrt(std::max(0.0, position.eigenvalues(1))),
          std::sqrt(std::max(0.0, covariance(2, 2)))};
}

MapperConfig withoutLaserOdometry(MapperConfig config) {
  config.laser_odometry = false;
  return config;
}

/// The hits of a scan without the space before them: all that a comparison of poses needs, and far
/// quicker to insert.
PlanarScan wallsOf(const PlanarScan& scan) {
  PlanarScan walls;
  for (const PlanarRay& ray : scan.rays) {
    if (!ray.hit || ray.known) continue;
    walls.rays.push_back(ray);
    walls.rays.back().origin = ray.end;
  }
  return walls;
}

}  // namespace

LaserOdometry::LaserOdometry(const MapperConfig& config) : config_(config) {}
LaserOdometry::~LaserOdometry() = default;
LaserOdometry::LaserOdometry(LaserOdometry&&) noexcept = default;
LaserOdometry& LaserOdometry::operator=(LaserOdometry&&) noexcept = default;

void LaserOdometry::begin(const PlanarScan& scan, const Pose2& map_T_base, bool is_matched) {
  stop();
  first_scan_ = scan;
  pose_ = first_pose_ = map_T_base;
  begins_at_match_ = is_matched;
}

void LaserOdometry::stop() {
  mapper_.reset();
  first_scan_.reset();
  error_ = PredictionError();
  begins_at_match_ = false;
}

bool LaserOdometry::follow(const PlanarScan& scan) {
  if (!first_scan_) return false;
  if (!mapper_) {
    mapper_ = std::make_unique<Mapper>(withoutLaserOdometry(config_));
    mapper_->reset(first_pose_);
    mapper_->process(*first_scan_);
  }
  const MapperResult result = mapper_->process(scan);
  if (!isUsable(result.pose) || !result.covariance.allFinite()) return false;
  pose_ = result.pose;
  if (!result.isMatched() || result.match.ambiguous) return false;
  error_ = PredictionError(errorOf(result.covariance));
  return true;
}

bool LaserOdometry::carry(const PlanarScan& scan, PredictionSource source,
                          const PredictionError& predicted, MotionModel& motion,
                          PoseUncertainty& uncertainty, MapperResult& result) {
  if (!config_.laser_odometry || source == PredictionSource::kOdometry) return false;
  // After a gap the vehicle may be where no scan was.
  if (motion.isGap(motion.secondsSince(scan))) return false;
  // A good prediction is better than scans that may show an object that covers the laser.
  if (!begins_at_match_ && !motion.isWide(predicted)) return false;
  if (!follow(scan)) return false;
  const PredictionError& error = begins_at_match_ ? error_ : predicted;
  result.followed = true;
  result.carried = !motion.isWide(error);
  if (result.carried) {
    uncertainty.carry(pose_, error);
  } else {
    uncertainty.lose(pose_, error);
  }
  if (result.carried) {
    motion.follow(pose_, scan);
    result.state = MatchState::kDegraded;
  } else {
    motion.move(pose_, pose_, true, scan);
  }
  return true;
}

bool LaserOdometry::agrees(const MatchRequest& request, const MatchResult& found) const {
  if (request.lost || request.prior || !begins_at_match_ || !first_scan_) return true;
  const SearchWindow& near = config_.matcher.near_window;
  const Pose2 moved = request.initial_guesses.front().between(found.pose);
  if (moved.distance() <= near.linear_m && std::abs(moved.yaw) <= near.angular_rad) return true;
  Submap last(config_.matchedGrid(), submapOptions(config_.matcher));
  last.insert(wallsOf(*first_scan_), first_pose_);
  MatchRequest alone = request;
  alone.memory = nullptr;  // it is of the searches in the map
  return !secondExplanation(last, alone, found, config_.matcher, config_.matcher.jump_margin);
}

std::optional<PredictionError> LaserOdometry::errorAfter(const MapperResult& result,
                                                         const PredictionError& predicted) const {
  if (result.isMatched()) return std::nullopt;
  return result.followed && begins_at_match_ ? error_ : predicted;
}

void LaserOdometry::update(const PlanarScan& scan, const MapperResult& result,
                           const Pose2& map_T_base) {
  if (!config_.laser_odometry) return;
  if (result.blank) {
    stop();
  } else if (result.isMatched() || !result.followed) {
    begin(scan, map_T_base, result.isMatched());
  }
}

std::size_t LaserOdometry::memoryBytes() const { return mapper_ ? mapper_->memoryBytes() : 0; }

}  // namespace kestrel
