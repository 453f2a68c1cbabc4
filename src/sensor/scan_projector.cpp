// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/scan_projector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "beam_masks.h"
#include "kestrel_slam/geometry/angles.h"
#include "scan_units.h"
#include "scan_validation.h"
#include "sweep_frames.h"
#include "unanswered_beams.h"

namespace kestrel {
namespace {

/// The directions of the beams in the laser plane, one after the other. Each is the previous one,
/// rotated by the angle increment: ten times faster than a sine and a cosine. Rounding errors add
/// up to about 1e-13 over a full turn.
class BeamDirections {
 public:
  explicit BeamDirections(const LaserScan& scan)
      : step_cos_(std::cos(scan.angle_increment)),
        step_sin_(std::sin(scan.angle_increment)),
        cos_(std::cos(scan.angle_min)),
        sin_(std::sin(scan.angle_min)) {}

  float cosine() const { return static_cast<float>(cos_); }
  float sine() const { return static_cast<float>(sin_); }

  void next() {
    const double turned = step_cos_ * cos_ - step_sin_ * sin_;
    sin_ = step_cos_ * sin_ + step_sin_ * cos_;
    cos_ = turned;
  }

 private:
  double step_cos_, step_sin_;
  double cos_, sin_;
};

/// rad; beams farther apart than this do not overlap at an edge
constexpr double kMaxMixedIncrement = 0.0075;

/// The directions of some neighboring beams in base_stabilized, and the position of the laser.
struct BeamBlock {
  static constexpr std::size_t kSize = 64;
  std::array<float, kSize> x, y, z;
  Eigen::Vector3f origin, origin_step;

  /// A block takes a few milliseconds. Within it, rotation and position change linearly.
  void fill(const SensorFrame& first, const SensorFrame& end, std::size_t count,
            BeamDirections& beam) {
    std::array<float, kSize> cosine, sine;
    for (std::size_t i = 0; i < count; ++i, beam.next()) {
      cosine[i] = beam.cosine();
      sine[i] = beam.sine();
    }
    const float share = 1.0F / static_cast<float>(count);
    const Eigen::Matrix3f change = share * (end.rotation - first.rotation);
    std::array<float, kSize>* const rows[] = {&x, &y, &z};
    for (Eigen::Index row = 0; row < 3; ++row) {
      const float forward = first.rotation(row, 0), left = first.rotation(row, 1);
      const float forward_step = change(row, 0), left_step = change(row, 1);
      float* const target = rows[row]->data();
      for (std::size_t i = 0; i < count; ++i) {
        const auto k = static_cast<float>(static_cast<int>(i));  // the conversion from int is fast
        target[i] = cosine[i] * (forward + k * forward_step) + sine[i] * (left + k * left_step);
      }
    }
    origin = first.origin;
    origin_step = share * (end.origin - first.origin);
  }
};

/// Collects the rays of one sweep.
class BeamProjector {
 public:
  BeamProjector(const LaserScan& scan, const ProjectorConfig& config, const SweepFrames& frames,
                const Slice& slice, std::vector<bool> mask, Projection& result)
      : scan_(scan),
        limits_(limitsOf(scan, config.beams)),
        slice_(slice),
        frames_(frames),
        jump_(std::abs(scan.angle_increment) < kMaxMixedIncrement
                  ? static_cast<float>(config.mixed_pixel_jump_m)
                  : 0.0F),
        vehicle_radius_(static_cast<float>(config.vehicle_radius_m)),
        mask_(std::move(mask)),
        result_(result) {}

  void run() {
    const std::size_t n = scan_.ranges.size();
    result_.scan.rays.reserve(n);
    BeamDirections beam(scan_);
    BeamBlock block;
    for (std::size_t first = 0; first < n; first += BeamBlock::kSize) {
      const std::size_t count = std::min(BeamBlock::kSize, n - first);
      block.fill(frames_.at(shareOf(first)), frames_.at(shareOf(first + count)), count, beam);
      Eigen::Vector3f origin = block.origin;
      for (std::size_t i = 0; i < count; ++i, origin += block.origin_step) {
        addBeam(first + i, {block.x[i], block.y[i], block.z[i]}, origin);
      }
    }
    unanswered_.appendTo(result_.scan.rays);
    result_.counts = counts_;
  }

 private:
  /// Time of a beam as a share of the sweep, 0 to 1.
  float shareOf(std::size_t beam) const {
    const std::size_t last = std::max<std::size_t>(scan_.ranges.size() - 1, 1);
    return static_cast<float>(beam) / static_cast<float>(last);
  }

  void addBeam(std::size_t i, const Eigen::Vector3f& d, const Eigen::Vector3f& origin) {
    const float range = scan_.ranges[i];
    if (!mask_.empty() && mask_[i]) {
      ++counts_.masked;
    } else if (range >= limits_.min && range < limits_.max) {
      addReturn(i, range, d, origin);
    } else if (range >= limits_.max && range > 0.0F) {
      ++counts_.clears;
      addFarBeam(range, d, origin);
    } else if (range > 0.0F || range == -std::numeric_limits<float>::infinity()) {
      ++counts_.too_close;
    } else {
      ++counts_.invalid;
    }
  }

  /// REP-117: +inf is no return. Some drivers send range_max. A return beyond the range limit of
  /// the configuration shows that the space before it is free.
  void addFarBeam(float range, const Eigen::Vector3f& d, const Eigen::Vector3f& origin) {
    const float length = std::min(limits_.clear, exitOf(slice_, origin.z(), d.z()).length);
    if (range < static_cast<float>(scan_.range_max)) {
      unanswered_.addReturn((origin + range * d).head<2>());
      addClear(d, origin, length);
    } else if (length > 0.0F) {
      unanswered_.addBeam(origin.head<2>(), length * d.head<2>());
    }
  }

  void addReturn(std::size_t i, float range, const Eigen::Vector3f& d,
                 const Eigen::Vector3f& origin) {
    const Eigen::Vector3f end = origin + range * d;
    if (jump_ > 0.0F && isMixed(i, range)) {
      ++counts_.mixed;
      return;
    }
    unanswered_.addReturn(end.head<2>());
    const SliceExit exit = exitOf(slice_, origin.z(), d.z());
    if (range > exit.length) {
      ++(range <= exit.surface ? counts_.outside : d.z() < 0.0F ? counts_.floor : counts_.ceiling);
      addClear(d, origin, exit.length);
    } else if (vehicle_radius_ > 0.0F &&
               end.head<2>().squaredNorm() < vehicle_radius_ * vehicle_radius_) {
      ++counts_.masked;
    } else {
      ++counts_.hits;
      write(origin, end, true);
    }
  }

  void addClear(const Eigen::Vector3f& d, const Eigen::Vector3f& origin, float length) {
    if (!(length > 0.0F)) return;
    write(origin, origin + length * d, false);
  }

  void write(const Eigen::Vector3f& origin, const Eigen::Vector3f& end, bool hit) {
    result_.scan.rays.push_back({origin.head<2>(), end.head<2>(), hit});
  }

  /// Whether a beam is a mixed pixel: at an edge it measures a range between the two surfaces, far
  /// from both neighbors. On a wall at a grazing angle the neighbors differ as much, but there the
  /// ranges keep growing on both sides.
  bool isMixed(std::size_t i, float range) const {
    constexpr float kFlat = 0.5F;  // relative to the jump; a smaller next step is not a jump
    if (i < 2 || i + 2 >= scan_.ranges.size()) return false;
    const float* r = scan_.ranges.data() + i;
    const float rise = range - r[-1], further = r[1] - range;
    if (!(std::abs(rise) > jump_ && std::abs(further) > jump_ && rise * further > 0.0F)) {
      return false;
    }
    return std::abs(r[-1] - r[-2]) < kFlat * std::abs(rise) ||
           std::abs(r[2] - r[1]) < kFlat * std::abs(further);
  }

  const LaserScan& scan_;
  const RangeLimits limits_;
  const Slice slice_;
  const SweepFrames& frames_;
  const float jump_;            ///< m
  const float vehicle_radius_;  ///< m
  const std::vector<bool> mask_;
  Projection& result_;
  UnansweredBeams unanswered_;
  BeamCounts counts_;
};

/// Some returns of a sweep in base_stabilized, origin at the base, m. One attitude for the whole
/// sweep is accurate enough to find floor and ceiling.
std::vector<Eigen::Vector3f> someReturns(const LaserScan& scan, const SweepFrames& frames,
                                         const ProjectorConfig& config) {
  constexpr std::size_t kBeams = 135;
  const RangeLimits limits = limitsOf(scan, config.beams);
  const std::size_t stride = std::max<std::size_t>(scan.ranges.size() / kBeams, 1);
  const SensorFrame frame = frames.at(0.5F);
  std::vector<Eigen::Vector3f> returns;
  for (std::size_t i = 0; i < scan.ranges.size(); i += stride) {
    const float range = scan.ranges[i];
    if (!(range >= limits.min && range < limits.max)) continue;
    const auto angle =
        static_cast<float>(scan.angle_min + static_cast<double>(i) * scan.angle_increment);
    const Eigen::Vector3f d =
        std::cos(angle) * frame.rotation.col(0) + std::sin(angle) * frame.rotation.col(1);
    returns.push_back(frame.origin + range * d);
  }
  return returns;
}

/// The plane of the beams. `height_m`: of the base over the floor. A plane that is steeper than 60
/// degrees is no slice of the walls.
ScanHeight heightOf(const SensorFrame& frame, double height_m) {
  constexpr float kLeastCosine = 0.5F;
  const Eigen::Vector3f normal = frame.rotation.col(2);
  if (!(std::abs(normal.z()) > kLeastCosine)) return {};
  ScanHeight height;
  height.slope = -normal.head<2>() / normal.z();
  height.base_m =
      static_cast<float>(height_m) + frame.origin.z() - height.slope.dot(frame.origin.head<2>());
  return height;
}

}  // namespace

ScanProjector::ScanProjector(const ProjectorConfig& config)
    : config_(config),
      ignored_(parseAngleRanges(config.ignored_angles)),
      mirror_(parseAngleRanges(config.mirror_angles)),
      range_correction_(config.range_correction) {}

void ScanProjector::configure(const ProjectorConfig& config) {
  ScanProjector next(config);
  next.surfaces_ = surfaces_;
  next.vehicle_returns_ = std::move(vehicle_returns_);
  *this = std::move(next);
}

SweepTimes sweepTimes(const LaserScan& scan) {
  const double beams = static_cast<double>(std::max<std::size_t>(scan.ranges.size(), 1) - 1);
  const double last = scan.stamp + beams * scan.time_increment;
  return hasUsableTimes(scan) && std::isfinite(last)
             ? SweepTimes{std::min(scan.stamp, last), std::max(scan.stamp, last)}
             : SweepTimes{scan.stamp, scan.stamp};
}

Projection ScanProjector::project(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser,
                                  const VehicleState& vehicle) {
  if (range_correction_.isEmpty()) return projectCorrected(scan, base_T_laser, vehicle);
  LaserScan corrected = scan;
  for (float& range : corrected.ranges) range = range_correction_.corrected(range);
  return projectCorrected(corrected, base_T_laser, vehicle);
}

/// The beams that hit the vehicle or a mirror; empty: none.
std::vector<bool> ScanProjector::ignoredBeams(const LaserScan& scan) {
  std::vector<bool> ignored = maskOf(scan, ignored_, mirror_);
  if (!config_.find_vehicle) return ignored;
  VehicleReturns& returns = vehicle_returns_[scan.frame];
  returns.observe(scan);
  returns.addTo(scan, ignored);
  return ignored;
}

Projection ScanProjector::projectCorrected(const LaserScan& scan,
                                           const Eigen::Isometry3d& base_T_laser,
                                           const VehicleState& vehicle) {
  if (auto problem = checkHeader(scan, base_T_laser, config_.beams)) return std::move(*problem);
  const SweepTimes times = sweepTimes(scan);
  const SweepFrames frames(times, scan.stamp, base_T_laser, vehicle);
  if (auto problem = checkAttitude(frames, scan.stamp, config_)) return std::move(*problem);

  Projection result;
  result.scan.stamp = scan.stamp;
  result.scan.time = scan.stamp;
  result.scan.source = scan.frame;
  result.scan.integrated_yaw = frames.integratedYaw();
  result.scan.integrated_acceleration = frames.integratedAcceleration();
  result.tilt_rad = frames.maxTilt();
  result.mirror_height_m = mirrorHeight(scan, base_T_laser, frames.attitude(), mirror_, config_);
  std::optional<double> height = vehicle.height_m ? vehicle.height_m : result.mirror_height_m;
  if (vehicle.attitude != nullptr && surfaces_.isDue(scan.stamp)) {
    surfaces_.observe(scan.stamp, someReturns(scan, frames, config_), frames.attitude(), height);
  }
  result.floor_height_m = surfaces_.floorSeenAt(scan.stamp);
  if (!height) height = surfaces_.floorHeight(scan.stamp);
  if (height) result.scan.height = heightOf(frames.at(0.5F), *height);
  const Slice slice = sliceOf(config_, height, surfaces_.ceilingHeight(scan.stamp, height),
                              frames.frame(0).origin.z());
  BeamProjector(scan, config_, frames, slice, ignoredBeams(scan), result).run();
  const std::string wrong_unit = unitProblem(scan, result.counts, config_.beams.min_range_m);
  if (!wrong_unit.empty()) return refused(ScanError::kWrongUnit, wrong_unit);
  result.warnings = warningsOf(scan);
  if (result.scan.rays.empty()) {
    result.error = ScanError::kNoValidBeam;
    result.message = noValidBeamText(result.counts);
  }
  return result;
}

}  // namespace kestrel
