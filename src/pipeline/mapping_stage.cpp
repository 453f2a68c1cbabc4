// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/mapping_stage.h"

#include <algorithm>
#include <utility>

namespace kestrel {
namespace {

constexpr double kHistory = 1.0;  // s; longer than any sweep
/// Step of the mapper's time for a scan that is not newer than the last one, s. Times of 1e9 s
/// have a resolution of 2e-7 s.
constexpr double kSmallStep = 1e-6;

PlanarRay moved(const Pose2& a_T_b, const PlanarRay& ray) {
  const Eigen::Isometry2f transform = Eigen::Translation2f(a_T_b.translation().cast<float>()) *
                                      Eigen::Rotation2Df(static_cast<float>(a_T_b.yaw));
  PlanarRay result = ray;
  result.origin = transform * ray.origin;
  result.end = transform * ray.end;
  return result;
}

}  // namespace

MappingStage::MappingStage(const MapperConfig& config, bool keep_out_moving) : mapper_(config) {
  keepOutMoving(keep_out_moving);
}

void MappingStage::keepOutMoving(bool enabled) {
  if (enabled == (moving_ != nullptr)) return;
  moving_ = enabled ? std::make_unique<MovingBeams>() : nullptr;
}

MapperResult MappingStage::process(PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                                   const std::optional<double>& time) {
  scan.time = time ? *time : time_base_.repair(scan.source, scan.stamp);
  if (!steps_.empty() && scan.time <= steps_.back().time) return processLate(scan);
  std::optional<PlanarScan> complete;
  if (moving_) {
    complete = scan;
    moving_->keepOut(scan);
  }
  const MapperResult result = match(scan, odom_T_base);
  if (moving_) moving_->add(*complete, result, odom_T_base);
  remember(scan, odom_T_base, result.pose);
  return result;
}

MapperResult MappingStage::match(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) {
  return localizer_ ? localizer_->process(scan, odom_T_base) : mapper_.process(scan, odom_T_base);
}

void MappingStage::localizeIn(Submap map) {
  localizeWith(std::make_unique<Localizer>(mapper_.config(), std::move(map)));
}

void MappingStage::localizeWith(std::unique_ptr<Localizer> localizer) {
  localizer_ = std::move(localizer);
  steps_.clear();
}

void MappingStage::mapAgain(const Pose2& map_T_base) {
  localizer_.reset();
  setPose(map_T_base);
}

/// The mapper cannot go back in time. So the scan is moved to the pose of the newest scan, and gets
/// its time and its readings of the other sensors.
MapperResult MappingStage::processLate(const PlanarScan& scan) {
  Step& last = steps_.back();
  const Pose2 last_T_scan = last.pose.inverse() * poseAt(scan.time).value_or(last.pose);
  PlanarScan current = scan;
  for (PlanarRay& ray : current.rays) ray = moved(last_T_scan, ray);
  last.time += kSmallStep;
  current.time = last.time;
  current.integrated_yaw = last.integrated_yaw;
  current.integrated_acceleration = last.integrated_acceleration;
  current.predicted = last.predicted;
  MapperResult result = match(current, last.odom_T_base);
  last.pose = result.pose;
  result.pose = result.pose * last_T_scan;
  return result;
}

/// Interpolates the poses of the last scans. Nothing if `time` is older.
std::optional<Pose2> MappingStage::poseAt(double time) const {
  const auto after = std::lower_bound(steps_.begin(), steps_.end(), time,
                                      [](const Step& step, double t) { return step.time < t; });
  if (after == steps_.end()) return std::nullopt;
  if (after == steps_.begin()) {
    return after->time == time ? std::optional(after->pose) : std::nullopt;
  }
  const Step &a = *(after - 1), &b = *after;
  return interpolate(a.pose, b.pose, (time - a.time) / (b.time - a.time));
}

void MappingStage::remember(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                            const Pose2& pose) {
  steps_.push_back({scan.time, pose, scan.integrated_yaw, scan.integrated_acceleration,
                    scan.predicted, odom_T_base});
  while (steps_.front().time < scan.time - kHistory) steps_.pop_front();
}

void MappingStage::reset(const Pose2& map_T_base) {
  if (localizer_) return setPose(map_T_base);
  steps_.clear();
  mapper_.reset(map_T_base);
  if (moving_) moving_->reset();
}

void MappingStage::setPose(const Pose2& map_T_base) {
  steps_.clear();
  if (localizer_) return localizer_->setPose(map_T_base);
  mapper_.setPose(map_T_base);
}

void MappingStage::restartMotion() {
  if (localizer_) return localizer_->restartMotion();
  const Pose2 pose = mapper_.pose();  // copy: setPose changes the value behind pose()
  setPose(pose);
}

}  // namespace kestrel
