// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/pipeline.h"

#include <algorithm>

namespace kestrel_slam {
namespace {

constexpr std::size_t kMaxWaitingScans = 40;  // a silent IMU: older ones are of no use

HeightConfig heightConfig(const ProjectorConfig& projector) {
  HeightConfig config;
  config.fixed_m = projector.height_m;
  return config;
}

}  // namespace

FilteredMapping::FilteredMapping(const SlamConfig& config, const PoseFilterConfig& filter_config,
                                 const CouplingOptions& options)
    : options_(options),
      filter_(filter_config),
      projector_(config.projector),
      tracker_(config.attitude),
      filtered_attitude_(config.attitude.buffer),
      height_(heightConfig(config.projector)),
      mapper_(config.mapper) {}

const AttitudeBuffer& FilteredMapping::attitude() const {
  return filter_gives_attitude_ ? filtered_attitude_ : tracker_.buffer();
}

/// Until the filter knows up from down, the tracker's attitude has to do.
void FilteredMapping::chooseAttitude() {
  const bool chosen = options_.attitude && filter_.output() && filter_.output()->givesAttitude();
  if (!chosen) filtered_attitude_.clear();
  if (chosen != filter_gives_attitude_) integrals_jump_ = true;
  filter_gives_attitude_ = chosen;
}

void FilteredMapping::addImu(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu,
                             double arrival) {
  deliverPoses(arrival);
  tracker_.add(sample, Eigen::Quaterniond(base_T_imu.linear()));
  const bool moved = filter_.addImu(sample, base_T_imu);
  chooseAttitude();
  if (moved) {
    const FilterOutput& now = *filter_.output();
    filtered_attitude_.add(now.stamp, Eigen::Quaterniond(now.map_T_base.linear()),
                           now.angular_velocity, now.specific_force);
    if (options_.height && now.givesHeight()) height_.addFiltered({now.stamp, now.height()});
    if (on_output) on_output(now);
  }
  processScans(arrival);
}

void FilteredMapping::addRange(const HeightSample& sample) {
  height_.addRange(sample, &attitude());
  filter_.addRange(sample);
}

void FilteredMapping::addBarometer(const HeightSample& sample) {
  if (options_.barometer) filter_.addBarometer(sample);
}

void FilteredMapping::addScan(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser) {
  scans_.push_back({scan, base_T_laser});
  if (scans_.size() > kMaxWaitingScans) scans_.pop_front();
}

void FilteredMapping::deliverPoses(double now) {
  for (; !poses_.empty() && poses_.front().arrival <= now; poses_.pop_front()) {
    filter_.addPose(poses_.front().pose);
  }
}

void FilteredMapping::processScans(double now) {
  while (!scans_.empty() && process(scans_.front(), now)) scans_.pop_front();
}

/// False where its attitude has not come yet.
bool FilteredMapping::process(const WaitingScan& waiting, double now) {
  const SweepTimes times = sweepTimes(waiting.scan);
  const std::optional<double> latest = attitude().latest();
  if (!latest || *latest < times.last) return false;
  VehicleState vehicle;
  vehicle.attitude = &attitude();
  vehicle.velocity = velocity_;
  const double stamp = waiting.scan.stamp;
  vehicle.height_m = height_.height(stamp);
  Projection projection = projector_.project(waiting.scan, waiting.base_T_laser, vehicle);
  height_.addProjection(stamp, projection);
  for (const auto& height : {projection.mirror_height_m, projection.floor_height_m}) {
    if (height) filter_.addFloorHeight({stamp, *height});
  }
  if (projection.error != ScanError::kNone) return true;
  projection.scan.time = stamp;
  if (integrals_jump_) projection.scan.integrated_yaw.reset();  // it counts from elsewhere
  integrals_jump_ = false;
  if (options_.prediction) {
    const std::optional<FilterOutput> predicted = filter_.at(stamp);
    if (predicted && predicted->givesPrediction()) {
      projection.scan.predicted = predicted->odomPose();
    }
  }
  const MapperResult result = mapper_.process(projection.scan);
  velocity_ = result.velocity;
  if (result.state != MatchState::kLost) {
    poses_.push_back({now + options_.match_s, {stamp, result.pose, result.covariance}});
  }
  if (on_scan) on_scan(projection.scan, result);
  return true;
}

}  // namespace kestrel_slam
