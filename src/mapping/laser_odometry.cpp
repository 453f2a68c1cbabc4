// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/laser_odometry.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "kestrel_slam/mapping/mapper.h"

namespace kestrel {
namespace {

/// So many scans are kept for the map.
constexpr std::size_t kMostScans = 20;

MotionError errorOf(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> position(covariance.topLeftCorner<2, 2>(),
                                                                Eigen::EigenvaluesOnly);
  return {std::sqrt(position.eigenvalues()(1)), std::sqrt(covariance(2, 2))};
}

MapperConfig withoutLaserOdometry(MapperConfig config) {
  config.laser_odometry = false;
  return config;
}

}  // namespace

LaserOdometry::LaserOdometry(const MapperConfig& config) : config_(withoutLaserOdometry(config)) {}
LaserOdometry::~LaserOdometry() = default;
LaserOdometry::LaserOdometry(LaserOdometry&&) noexcept = default;
LaserOdometry& LaserOdometry::operator=(LaserOdometry&&) noexcept = default;

void LaserOdometry::begin(const PlanarScan& scan, const Pose2& map_T_base,
                          const PredictionError& error) {
  stop();
  scans_.push_back({scan, map_T_base, error});
  pose_ = first_pose_ = map_T_base;
  error_ = first_error_ = error;
}

void LaserOdometry::stop() {
  mapper_.reset();
  scans_.clear();
  steps_ = 0;
  following_ = false;
}

void LaserOdometry::restart() {
  mapper_ = std::make_unique<Mapper>(config_);
  mapper_->reset(first_pose_);
  mapper_->process(scans_.front().scan);
}

bool LaserOdometry::follow(const PlanarScan& scan) {
  following_ = false;
  if (scans_.empty()) return false;
  if (!mapper_) restart();
  const MapperResult result = mapper_->process(scan);
  pose_ = result.pose;
  following_ = result.isMatched();
  if (!following_) return false;
  ++steps_;
  error_ = first_error_;
  error_.add(errorOf(result.covariance), (pose_.translation() - first_pose_.translation()).norm());
  if (!result.inserted) return true;
  if (scans_.size() == kMostScans) scans_.erase(scans_.begin());
  scans_.push_back({scan, pose_, error_});
  return true;
}

}  // namespace kestrel
