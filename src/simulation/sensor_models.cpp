// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/simulation/sensor_models.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "infinity.h"
#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The beams of a sweep: `steps` azimuths, each with one beam per elevation.
struct Fan {
  double angle_min, angle_increment;  ///< rad
  double seconds_per_step;
  std::size_t steps;
  std::vector<double> elevations;  ///< rad
  double range_min, range_max;     ///< m

  double azimuth(std::size_t step) const {
    return angle_min + static_cast<double>(step) * angle_increment;
  }
};

Eigen::Vector3d beamDirection(double azimuth, double elevation) {
  const double level = std::cos(elevation);
  return {level * std::cos(azimuth), level * std::sin(azimuth), std::sin(elevation)};
}

double sigmaAt(double range, const BeamErrors& errors) {
  return std::hypot(errors.sigma_m, errors.sigma_per_m * range);
}

/// The range of the surface that a beam sees; +inf if there is no return, as from black surfaces or
/// at grazing incidence.
double seenRange(const RayHit& hit, const BeamErrors& errors) {
  if (hit.material == Material::kBlack || hit.cosine < errors.min_cosine) return kInfinity;
  return hit.distance;
}

/// The reading of one beam, with the special values of REP-117. `edge` is the range that the border
/// of the beam sees.
double measure(double range, double edge, const Fan& fan, const BeamErrors& errors,
               Random& random) {
  // Every beam draws the same number of random values, so that it cannot change the next beam.
  const bool dropped = random.uniform() < errors.dropout_probability;
  const double edge_share = random.uniform();
  const double noise = random.gaussian();
  if (dropped) return kNaN;
  if (std::isfinite(edge) && std::isfinite(range)) range += edge_share * (edge - range);
  if (!std::isfinite(range)) return kInfinity;
  range += sigmaAt(range, errors) * noise;
  if (errors.resolution_m > 0.0) {
    range = std::round(range / errors.resolution_m) * errors.resolution_m;
  }
  if (range < fan.range_min) return -kInfinity;
  return range < fan.range_max ? range : kInfinity;
}

/// Casts the beams of one sweep, each from the sensor's pose at the time of that beam.
class BeamCaster {
 public:
  BeamCaster(const Fan& fan, const BeamErrors& errors, const World& world, const Motion& motion,
             const Eigen::Isometry3d& base_T_sensor, double time)
      : fan_(fan),
        errors_(errors),
        world_(world),
        motion_(motion),
        base_T_sensor_(base_T_sensor),
        time_(time),
        farthest_(fan.range_max + kSigmas * sigmaAt(fan.range_max, errors)) {}

  /// The readings, ordered by step, then by elevation.
  std::vector<double> readings(Random& random) {
    cast();
    std::vector<double> readings;
    readings.reserve(seen_.size());
    for (std::size_t step = 0; step < fan_.steps; ++step) {
      for (std::size_t ring = 0; ring < fan_.elevations.size(); ++ring) {
        readings.push_back(
            measure(seen_[index(step, ring)], edgeRange(step, ring), fan_, errors_, random));
      }
    }
    return readings;
  }

 private:
  static constexpr double kSigmas = 6.0;      // noise cannot bring farther surfaces into range
  static constexpr double kMixedJump = 0.05;  // m; smaller steps between surfaces are not edges

  std::size_t index(std::size_t step, std::size_t ring) const {
    return step * fan_.elevations.size() + ring;
  }

  double timeOf(std::size_t step) const {
    return time_ + static_cast<double>(step) * fan_.seconds_per_step;
  }

  Eigen::Isometry3d sensorAt(std::size_t step) const {
    return motion_.at(timeOf(step)).world_T_base * base_T_sensor_;
  }

  double castBeam(const Eigen::Isometry3d& world_T_sensor, const Eigen::Vector3d& direction,
                  std::size_t step) const {
    return seenRange(world_.cast(world_T_sensor.translation(), world_T_sensor.linear() * direction,
                                 timeOf(step), farthest_),
                     errors_);
  }

  void cast() {
    seen_.reserve(fan_.steps * fan_.elevations.size());
    Eigen::Isometry3d world_T_sensor = sensorAt(0);
    for (std::size_t step = 0; step < fan_.steps; ++step) {
      if (fan_.seconds_per_step > 0.0) world_T_sensor = sensorAt(step);
      for (const double elevation : fan_.elevations) {
        seen_.push_back(
            castBeam(world_T_sensor, beamDirection(fan_.azimuth(step), elevation), step));
      }
    }
  }

  /// The range that the border of the beam sees if a neighbor in the sweep sees another surface;
  /// +inf if the whole beam hits one surface.
  double edgeRange(std::size_t step, std::size_t ring) const {
    if (errors_.divergence_rad <= 0.0 || !std::isfinite(seen_[index(step, ring)])) {
      return kInfinity;
    }
    const double middle = seen_[index(step, ring)];
    const auto differs = [&](std::size_t neighbor) {
      return std::abs(seen_[index(neighbor, ring)] - middle) > kMixedJump;
    };
    const bool candidate =
        (step > 0 && differs(step - 1)) || (step + 1 < fan_.steps && differs(step + 1));
    if (!candidate) return kInfinity;
    const double before = borderRange(step, ring, -0.5), after = borderRange(step, ring, 0.5);
    // Along a flat wall, the inverse range is nearly linear in the angle over a small beam.
    const double bend = middle * middle * std::abs(2.0 / middle - 1.0 / before - 1.0 / after);
    if (bend <= kMixedJump) return kInfinity;
    return std::abs(before - middle) > std::abs(after - middle) ? before : after;
  }

  /// The range at an offset from the middle of the beam; `share` is the offset per divergence.
  double borderRange(std::size_t step, std::size_t ring, double share) const {
    const double azimuth = fan_.azimuth(step) + share * errors_.divergence_rad;
    return castBeam(sensorAt(step), beamDirection(azimuth, fan_.elevations[ring]), step);
  }

  const Fan& fan_;
  const BeamErrors& errors_;
  const World& world_;
  const Motion& motion_;
  const Eigen::Isometry3d& base_T_sensor_;
  double time_;
  double farthest_;
  std::vector<double> seen_;  // m, without noise
};

PointCloud::Point toPoint(double range, const Eigen::Vector3d& direction, double time) {
  const double seen = std::isfinite(range) ? range : kNaN;
  const Eigen::Vector3f point = (seen * direction).cast<float>();
  return {point.x(), point.y(), point.z(), static_cast<float>(time)};
}

}  // namespace

LaserScan sweep(const LaserModel& laser, const World& world, const Motion& motion,
                const Eigen::Isometry3d& base_T_laser, double time, Random& random) {
  const Fan fan = {laser.angle_min,
                   laser.angle_increment,
                   laser.time_increment,
                   static_cast<std::size_t>(std::max(laser.beams, 0)),
                   {0.0},
                   laser.range_min,
                   laser.range_max};
  const std::vector<double> readings =
      BeamCaster(fan, laser.errors, world, motion, base_T_laser, time).readings(random);
  LaserScan scan;
  scan.stamp = time;
  scan.angle_min = laser.angle_min;
  scan.angle_increment = laser.angle_increment;
  scan.time_increment = laser.time_increment;
  scan.range_min = laser.range_min;
  scan.range_max = laser.range_max;
  scan.ranges.reserve(readings.size());
  for (const double range : readings) scan.ranges.push_back(static_cast<float>(range));
  return scan;
}

PointCloud sweep(const LidarModel& lidar, const World& world, const Motion& motion,
                 const Eigen::Isometry3d& base_T_lidar, double time, Random& random) {
  // A Velodyne turns clockwise, seen from above. Its driver starts each turn behind the sensor.
  const Fan fan = {kPi,
                   -2.0 * kPi / lidar.columns,
                   1.0 / (lidar.rate_hz * lidar.columns),
                   static_cast<std::size_t>(std::max(lidar.columns, 0)),
                   lidar.elevations,
                   lidar.range_min,
                   lidar.range_max};
  const std::vector<double> readings =
      BeamCaster(fan, lidar.errors, world, motion, base_T_lidar, time).readings(random);
  PointCloud cloud;
  cloud.stamp = time;
  cloud.points.reserve(readings.size());
  for (std::size_t column = 0, i = 0; column < fan.steps; ++column) {
    const double elapsed = static_cast<double>(column) * fan.seconds_per_step;
    for (const double elevation : lidar.elevations) {
      cloud.points.push_back(
          toPoint(readings[i++], beamDirection(fan.azimuth(column), elevation), elapsed));
    }
  }
  return cloud;
}

}  // namespace kestrel
