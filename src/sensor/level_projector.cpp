#include "kestrel_slam/sensor/level_projector.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel_slam {
namespace {

/// Beams may lie at most this far apart; farther, two of them already cover more than a turn.
constexpr double kMaxIncrement = kPi;
/// Rounding of a float32 increment, summed over a full turn of beams, rad.
constexpr double kFieldOfViewTolerance = 1e-3;

/// The limits of one scan, in the type of its ranges so that equal numbers compare equal.
struct RangeLimits {
  float min;    ///< closer is too close
  float max;    ///< here and beyond is no return
  float clear;  ///< a beam without a return clears up to here; 0: not at all
};

RangeLimits limitsOf(const LaserScan& scan, const BeamFilterConfig& config) {
  // Some drivers leave range_max at 0.
  const double sensor_max = scan.range_max == 0.0 ? config.max_range_m : scan.range_max;
  const double max = std::min(config.max_range_m, sensor_max);
  return {static_cast<float>(std::max(config.min_range_m, scan.range_min)), static_cast<float>(max),
          static_cast<float>(std::max(0.0, std::min(config.clear_range_m, max)))};
}

/// What is wrong with the angles of a scan, or an empty text.
std::string angleProblem(const LaserScan& scan) {
  std::ostringstream text;
  const double step = std::abs(scan.angle_increment);
  const double field_of_view = step * static_cast<double>(scan.ranges.size() - 1);
  if (!std::isfinite(scan.angle_min)) {
    text << "angle_min is " << scan.angle_min << ", must be finite";
  } else if (!std::isfinite(step) || step == 0.0 || step > kMaxIncrement) {
    text << "angle_increment is " << scan.angle_increment
         << " rad, must not be 0 and at most pi in size";
  } else if (field_of_view > 2.0 * kPi + step + kFieldOfViewTolerance) {
    text << scan.ranges.size() << " beams at angle_increment " << scan.angle_increment
         << " rad make " << field_of_view << " rad, more than a full turn";
  }
  return text.str();
}

std::string rangeProblem(const LaserScan& scan) {
  const bool max_is_set = scan.range_max != 0.0;
  const bool usable = std::isfinite(scan.range_min) && !std::isnan(scan.range_max) &&
                      (!max_is_set || scan.range_max > scan.range_min);
  if (usable) return "";
  std::ostringstream text;
  text << "range_min is " << scan.range_min << " and range_max " << scan.range_max
       << " m, range_max must be the larger";
  return text.str();
}

std::string mountingProblem(const Eigen::Isometry3d& base_T_laser) {
  // In the type of the rays: what overflows a float is as bad as what is infinite.
  const bool finite = base_T_laser.matrix().cast<float>().allFinite();
  return finite ? "" : "the transform from laser to base is not finite";
}

Projection refused(ScanError error, const std::string& message) {
  Projection result;
  result.error = error;
  result.message = message;
  return result;
}

std::string numberText(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// The reason to refuse a scan before looking at its ranges.
std::optional<Projection> checkHeader(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser,
                                      const BeamFilterConfig& config) {
  if (scan.ranges.empty()) return refused(ScanError::kNoBeams, "the scan has no beams");
  if (scan.ranges.size() > static_cast<std::size_t>(std::max(0, config.max_beams))) {
    return refused(ScanError::kTooManyBeams, "the scan has " + std::to_string(scan.ranges.size()) +
                                                 " beams, max_beams allows " +
                                                 std::to_string(config.max_beams));
  }
  if (!std::isfinite(scan.stamp)) {
    return refused(ScanError::kBadStamp,
                   "the stamp is " + numberText(scan.stamp) + ", must be finite");
  }
  std::string problem = angleProblem(scan);
  if (problem.empty()) problem = rangeProblem(scan);
  if (problem.empty()) problem = mountingProblem(base_T_laser);
  if (problem.empty()) return std::nullopt;
  return refused(ScanError::kBadGeometry, problem);
}

/// The horizontal directions of the beams in the base frame, one after the other. Turning the last
/// one costs a tenth of a sine and a cosine; over a full turn of beams the rounding adds up to some
/// 1e-13.
class BeamDirections {
 public:
  BeamDirections(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser)
      : step_cos_(std::cos(scan.angle_increment)), step_sin_(std::sin(scan.angle_increment)) {
    const Eigen::Matrix2d horizontal = base_T_laser.linear().topLeftCorner<2, 2>();
    const double c = std::cos(scan.angle_min), s = std::sin(scan.angle_min);
    current_ = horizontal * Eigen::Vector2d(c, s);
    ahead_ = horizontal * Eigen::Vector2d(-s, c);
  }

  Eigen::Vector2f current() const { return current_.cast<float>(); }

  void next() {
    const Eigen::Vector2d turned = step_cos_ * current_ + step_sin_ * ahead_;
    ahead_ = step_cos_ * ahead_ - step_sin_ * current_;
    current_ = turned;
  }

 private:
  double step_cos_, step_sin_;
  Eigen::Vector2d current_;
  Eigen::Vector2d ahead_;  ///< where a beam a quarter turn further on points
};

/// Classifies every beam and adds the rays of those that say something.
void addRays(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser,
             const RangeLimits& limits, Projection& result) {
  const Eigen::Vector2f origin = base_T_laser.translation().head<2>().cast<float>();
  std::vector<PlanarRay>& rays = result.scan.rays;
  rays.reserve(scan.ranges.size());
  BeamCounts counts;
  BeamDirections beam(scan, base_T_laser);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i, beam.next()) {
    const float range = scan.ranges[i];
    if (range >= limits.min && range < limits.max && range > 0.0F) {
      ++counts.hits;
      rays.push_back({origin, origin + range * beam.current(), true});
    } else if (range >= limits.max && range > 0.0F) {  // REP-117: +inf is no return
      ++counts.clears;
      if (limits.clear > 0.0F) {
        rays.push_back({origin, origin + limits.clear * beam.current(), false});
      }
    } else if (range > 0.0F || range == -std::numeric_limits<float>::infinity()) {
      ++counts.too_close;
    } else {
      ++counts.invalid;
    }
  }
  result.counts = counts;
}

std::string noValidBeamText(const BeamCounts& counts) {
  std::ostringstream text;
  text << "no usable beam: " << counts.invalid << " invalid, " << counts.too_close << " too close, "
       << counts.clears << " without a return";
  return text.str();
}

}  // namespace

const char* toString(ScanError error) {
  switch (error) {
    case ScanError::kNone:
      return "none";
    case ScanError::kNoBeams:
      return "no-beams";
    case ScanError::kBadGeometry:
      return "bad-geometry";
    case ScanError::kTooManyBeams:
      return "too-many-beams";
    case ScanError::kNoValidBeam:
      return "no-valid-beam";
    case ScanError::kBadStamp:
      return "bad-stamp";
  }
  return "unknown";
}

Projection LevelProjector::project(const LaserScan& scan,
                                   const Eigen::Isometry3d& base_T_laser) const {
  if (auto problem = checkHeader(scan, base_T_laser, config_)) return std::move(*problem);

  Projection result;
  result.scan.stamp = scan.stamp;
  result.scan.time = scan.stamp;
  addRays(scan, base_T_laser, limitsOf(scan, config_), result);
  if (result.scan.rays.empty()) {
    result.error = ScanError::kNoValidBeam;
    result.message = noValidBeamText(result.counts);
  }
  return result;
}

}  // namespace kestrel_slam
