// SPDX-License-Identifier: BSD-3-Clause
#include "scan_validation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "number_text.h"

namespace kestrel {
namespace {

/// Largest angle increment, rad. With a larger one two beams cover more than a full turn.
constexpr double kMaxIncrement = kPi;
/// Rounding error of a float32 increment, summed over a full turn, rad.
constexpr double kFieldOfViewTolerance = 1e-3;

/// What is wrong with the angles of a scan, or an empty text.
std::string angleProblem(const LaserScan& scan) {
  std::ostringstream text;
  const double step = std::abs(scan.angle_increment);
  const double field_of_view = step * static_cast<double>(scan.ranges.size() - 1);
  if (!std::isfinite(scan.angle_min)) {
    text << "angle_min is " << scan.angle_min << ", must be finite";
  } else if (!std::isfinite(step) || step == 0.0 || step > kMaxIncrement) {
    text << "angle_increment is " << scan.angle_increment
         << " rad, its size must be above 0 and at most pi";
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
    case ScanError::kTilted:
      return "tilted";
    case ScanError::kNoAttitude:
      return "no-attitude";
    case ScanError::kWrongUnit:
      return "wrong-unit";
  }
  return "unknown";
}

std::string textOf(const std::vector<ScanWarning>& warnings) {
  std::string text;
  for (const ScanWarning& warning : warnings) {
    text += (text.empty() ? "" : "; ") + std::string(warning.kind) + ": " + warning.text;
  }
  return text;
}

RangeLimits limitsOf(const LaserScan& scan, const BeamFilterConfig& config) {
  // Some drivers leave range_max at 0.
  const double sensor_max = scan.range_max == 0.0 ? config.max_range_m : scan.range_max;
  const double max = std::min(config.max_range_m, sensor_max);
  const double min = std::max(config.min_range_m, scan.range_min);
  // Some lasers send 0 for a missing reading, also if range_min is 0.
  return {std::max(static_cast<float>(min), std::numeric_limits<float>::min()),
          static_cast<float>(max),
          static_cast<float>(std::max(0.0, std::min(config.clear_range_m, max)))};
}

Projection refused(ScanError error, const std::string& message) {
  Projection result;
  result.error = error;
  result.message = message;
  return result;
}

std::string mountingProblem(const Eigen::Isometry3d& base_T_laser) {
  // Checked as float, the type of the rays: a value that overflows a float is invalid too.
  const bool finite = base_T_laser.matrix().cast<float>().allFinite();
  return finite ? "" : "the transform from laser to base is not finite";
}

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

std::string noValidBeamText(const BeamCounts& counts) {
  const std::pair<std::size_t, const char*> kinds[] = {{counts.invalid, "invalid"},
                                                       {counts.too_close, "too close"},
                                                       {counts.clears, "without a return"},
                                                       {counts.masked, "masked"},
                                                       {counts.mixed, "mixed"},
                                                       {counts.floor, "on the floor"},
                                                       {counts.ceiling, "on the ceiling"},
                                                       {counts.outside, "outside of the slice"}};
  std::string text;
  for (const auto& [count, kind] : kinds) {
    if (count == 0) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + kind;
  }
  return "no usable beam: " + (text.empty() ? "no points" : text);
}

}  // namespace kestrel
