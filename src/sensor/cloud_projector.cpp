// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/sensor/scan_projector.h"
#include "scan_validation.h"
#include "sweep_frames.h"

namespace kestrel {
namespace {

constexpr std::size_t kMaxPoints = 2'000'000;  // of one sweep; the largest lidars send 300 000
constexpr double kMaxSweep = 1.0;              // s; a sweep whose point times span more is invalid

/// The points in one azimuth direction.
struct Bin {
  float hit_distance = std::numeric_limits<float>::infinity();  ///< nearest return in the slice, m
  float clear_distance = 0.0F;  ///< largest distance that a beam has cleared, m
  Eigen::Vector2f hit, clear, origin;
};

class CloudSlicer {
 public:
  CloudSlicer(const PointCloud& cloud, const ProjectorConfig& config, const SweepFrames& frames,
              const SweepTimes& times, const Slice& slice, Projection& result)
      : cloud_(cloud),
        config_(config),
        frames_(frames),
        first_(static_cast<float>(times.first - cloud.stamp)),
        duration_(static_cast<float>(times.last - times.first)),
        slice_(slice),
        result_(result),
        bins_(static_cast<std::size_t>(config.azimuth_bins)) {}

  void run() {
    SensorFrame frame = frames_.at(0.0F);
    float time = first_;
    for (const PointCloud::Point& point : cloud_.points) {
      if (point.time != time) {  // all points of a column have the same time
        time = point.time;
        frame = frames_.at(duration_ > 0.0F ? (time - first_) / duration_ : 0.0F);
      }
      addPoint(point, frame);
    }
    for (const Bin& bin : bins_) addRay(bin);
  }

 private:
  void addPoint(const PointCloud::Point& source, const SensorFrame& frame) {
    const Eigen::Vector3f point(source.x, source.y, source.z);
    const float range = point.norm();
    if (!std::isfinite(range) || range == 0.0F || std::isnan(source.time)) {
      ++result_.counts.invalid;
      return;
    }
    if (range < static_cast<float>(config_.beams.min_range_m)) {
      ++result_.counts.too_close;
      return;
    }
    const Eigen::Vector3f d = frame.rotation * (point / range);
    const Eigen::Vector2f origin = frame.origin.head<2>();
    const Eigen::Vector2f end = origin + range * d.head<2>();
    const auto radius = static_cast<float>(config_.vehicle_radius_m);
    if (radius > 0.0F && end.squaredNorm() < radius * radius) {
      ++result_.counts.masked;
      return;
    }
    const SliceExit exit = exitOf(slice_, frame.origin.z(), d.z());
    const float usable = std::min(exit.length, static_cast<float>(config_.beams.max_range_m));
    const float horizontal = d.head<2>().norm();
    Bin& bin = binOf(d);
    if (range <= usable) {
      addHit(bin, range * horizontal, origin, end);
    } else {
      ++(range <= exit.length    ? result_.counts.clears
         : range <= exit.surface ? result_.counts.outside
         : d.z() < 0.0F          ? result_.counts.floor
                                 : result_.counts.ceiling);
      addClear(bin, usable * horizontal, origin, origin + usable * d.head<2>());
    }
  }

  Bin& binOf(const Eigen::Vector3f& d) {
    const float turn =
        (std::atan2(d.y(), d.x()) + static_cast<float>(kPi)) / static_cast<float>(2.0 * kPi);
    const float place = turn * static_cast<float>(bins_.size());
    const std::size_t index = place > 0.0F ? static_cast<std::size_t>(place) : 0;  // not for NaN
    return bins_[std::min(index, bins_.size() - 1)];
  }

  static void addHit(Bin& bin, float distance, const Eigen::Vector2f& origin,
                     const Eigen::Vector2f& end) {
    if (distance >= bin.hit_distance) return;
    bin.hit_distance = distance;
    bin.hit = end;
    bin.origin = origin;
  }

  static void addClear(Bin& bin, float distance, const Eigen::Vector2f& origin,
                       const Eigen::Vector2f& end) {
    if (!(distance > bin.clear_distance)) return;
    bin.clear_distance = distance;
    bin.clear = end;
    if (!std::isfinite(bin.hit_distance)) bin.origin = origin;
  }

  void addRay(const Bin& bin) {
    if (std::isfinite(bin.hit_distance)) {
      ++result_.counts.hits;
      result_.scan.rays.push_back({bin.origin, bin.hit, true});
    } else if (bin.clear_distance > 0.0F) {
      result_.scan.rays.push_back({bin.origin, bin.clear, false});
    }
  }

  const PointCloud& cloud_;
  const ProjectorConfig& config_;
  const SweepFrames& frames_;
  const float first_, duration_;  ///< of the sweep, s, relative to the stamp
  const Slice slice_;
  Projection& result_;
  std::vector<Bin> bins_;
};

std::optional<Projection> checkCloud(const PointCloud& cloud,
                                     const Eigen::Isometry3d& base_T_lidar) {
  if (cloud.points.empty()) return refused(ScanError::kNoBeams, "the cloud has no points");
  if (cloud.points.size() > kMaxPoints) {
    return refused(ScanError::kTooManyBeams,
                   "the cloud has " + std::to_string(cloud.points.size()) + " points, more than " +
                       std::to_string(kMaxPoints));
  }
  if (!std::isfinite(cloud.stamp)) {
    return refused(ScanError::kBadStamp, "the stamp of the cloud is not finite");
  }
  const SweepTimes times = sweepTimes(cloud);
  if (!(times.last - times.first <= kMaxSweep)) {
    return refused(ScanError::kBadGeometry, "the point times of the cloud span more than " +
                                                std::to_string(kMaxSweep) +
                                                " s; is their unit seconds?");
  }
  const std::string problem = mountingProblem(base_T_lidar);
  if (!problem.empty()) return refused(ScanError::kBadGeometry, problem);
  return std::nullopt;
}

}  // namespace

SweepTimes sweepTimes(const PointCloud& cloud) {
  SweepTimes times{cloud.stamp, cloud.stamp};
  for (const PointCloud::Point& point : cloud.points) {
    if (std::isnan(point.time)) continue;
    times.first = std::min(times.first, cloud.stamp + static_cast<double>(point.time));
    times.last = std::max(times.last, cloud.stamp + static_cast<double>(point.time));
  }
  return times;
}

Projection ScanProjector::project(const PointCloud& cloud, const Eigen::Isometry3d& base_T_lidar,
                                  const VehicleState& vehicle) {
  if (auto problem = checkCloud(cloud, base_T_lidar)) return std::move(*problem);
  const SweepTimes times = sweepTimes(cloud);
  const SweepFrames frames(times, cloud.stamp, base_T_lidar, vehicle);
  if (auto problem = checkAttitude(frames, cloud.stamp, config_)) return std::move(*problem);

  Projection result;
  result.scan.stamp = cloud.stamp;
  result.scan.time = cloud.stamp;
  result.scan.source = cloud.frame;
  result.scan.integrated_yaw = frames.integratedYaw();
  result.scan.integrated_acceleration = frames.integratedAcceleration();
  result.tilt_rad = frames.maxTilt();
  const Slice slice = sliceOf(config_, vehicle.height_m, std::nullopt, frames.frame(0).origin.z());
  CloudSlicer(cloud, config_, frames, times, slice, result).run();
  if (result.scan.rays.empty()) {
    result.error = ScanError::kNoValidBeam;
    result.message = noValidBeamText(result.counts);
  }
  return result;
}

}  // namespace kestrel
