// SPDX-License-Identifier: BSD-3-Clause
#include "scan_units.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>
#include <vector>

#include "number_text.h"

namespace kestrel {
namespace {

constexpr double kMaxScanTime = 1.0;       // s; all 2D lasers turn faster
constexpr double kMaxLaserRange = 1000.0;  // m; no 2D laser measures so far
constexpr double kMillimetersPerMeter = 1e3;

double sweepOf(const LaserScan& scan) {
  const auto steps = static_cast<double>(std::max<std::size_t>(scan.ranges.size(), 1) - 1);
  return std::abs(steps * scan.time_increment);
}

/// The unit that makes a sweep possible, as a question; empty if there is none.
std::string timeUnitOf(double sweep) {
  for (const auto& [factor, unit] :
       {std::pair{1e3, "milliseconds"}, {1e6, "microseconds"}, {1e9, "nanoseconds"}}) {
    if (sweep / factor <= kMaxScanTime) return std::string(": ") + unit + "?";
  }
  return "";
}

std::string timeText(const LaserScan& scan) {
  const double sweep = sweepOf(scan);
  std::ostringstream text;
  text << "time_increment " << scan.time_increment << " s makes a sweep of " << sweep << " s"
       << timeUnitOf(sweep) << " It is ignored: all beams get the stamp of the scan";
  return text.str();
}

std::string fewBeamsText(const LaserScan& scan) {
  return "the scan has " + std::to_string(scan.ranges.size()) + " beams: fewer than " +
         std::to_string(kMinBeamsToMatch) +
         " cannot be matched reliably; use odometry (offline: --odometry use)";
}

/// The measured ranges of a scan, and those of them that are beyond one of its limits.
struct BeyondLimit {
  std::size_t measured = 0;  ///< finite and above 0
  std::vector<float> beyond;

  template <typename IsBeyond>
  BeyondLimit(const LaserScan& scan, const IsBeyond& is_beyond) {
    for (const float range : scan.ranges) {
      if (!std::isfinite(range) || range <= 0.0F) continue;
      ++measured;
      if (is_beyond(range)) beyond.push_back(range);
    }
  }

  bool most() const { return 2 * beyond.size() > measured; }

  /// Some lasers send one number for a missing return, for example 65.533 or range_max + 1.
  bool isOneNumber() const {
    const auto differs = [this](float range) { return range != beyond.front(); };
    return std::none_of(beyond.begin(), beyond.end(), differs);
  }

  double median() {
    const auto middle = beyond.begin() + static_cast<std::ptrdiff_t>(beyond.size() / 2);
    std::nth_element(beyond.begin(), middle, beyond.end());
    return *middle;
  }

  std::string text(const std::string& where, double limit) const {
    const std::string count = beyond.size() == measured ? "every beam"
                                                        : std::to_string(beyond.size()) + " of " +
                                                              std::to_string(measured) + " beams";
    return count + (beyond.size() == measured ? " is " : " are ") + where + " " +
           numberText(limit) + " m";
  }
};

std::string tooFarText(const LaserScan& scan, double min_range_m) {
  const double max =
      scan.range_max > 0.0 ? std::min(scan.range_max, kMaxLaserRange) : kMaxLaserRange;
  BeyondLimit far(scan, [max](float range) { return range > max; });
  if (!far.most() || far.isOneNumber()) return "";
  const double median = far.median(), meters = median / kMillimetersPerMeter;
  if (meters < std::max(scan.range_min, min_range_m) || meters > max) return "";
  return far.text("beyond range_max", max) + ": millimeters? The median is " + numberText(median) +
         "; the driver must send m";
}

std::string tooCloseText(const LaserScan& scan) {
  const double min = scan.range_min, min_m = min / kMillimetersPerMeter;
  BeyondLimit close(scan, [min](float range) { return range < min; });
  if (!close.most() || close.isOneNumber() || close.median() < min_m || min < 1.0) return "";
  return close.text("closer than range_min", min) +
         ": is range_min in millimeters? The median is " + numberText(close.median()) + " m";
}

}  // namespace

bool hasUsableTimes(const LaserScan& scan) { return sweepOf(scan) <= kMaxScanTime; }

std::vector<ScanWarning> warningsOf(const LaserScan& scan) {
  std::vector<ScanWarning> warnings;
  if (!hasUsableTimes(scan)) warnings.push_back({"time-increment", timeText(scan)});
  if (scan.ranges.size() < kMinBeamsToMatch) warnings.push_back({"few-beams", fewBeamsText(scan)});
  return warnings;
}

std::string unitProblem(const LaserScan& scan, const BeamCounts& counts, double min_range_m) {
  if (2 * counts.hits >= scan.ranges.size()) return "";
  const std::string text = tooFarText(scan, min_range_m);
  return text.empty() ? tooCloseText(scan) : text;
}

}  // namespace kestrel
