// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/scan_turn.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr int kBins = 360;
constexpr int kMaxShift = 60;      // bins
constexpr int kFewestPairs = 45;   // bins that both sweeps measured
constexpr float kMaxCost = 0.5F;   // m; larger differences are other objects
constexpr double kDistinct = 0.6;  // the best shift must be this much better than a typical one
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Writes the nearest distance into the bin of the direction.
void put(double angle, float range, std::vector<float>& bins) {
  if (!(range > 0.0F) || !std::isfinite(range) || !std::isfinite(angle)) return;
  const double share = (normalizeAngle(angle) + kPi) / (2.0 * kPi);
  float& bin = bins[static_cast<std::size_t>(share * kBins) % kBins];
  bin = std::isnan(bin) ? range : std::min(bin, range);
}

/// Mean difference of the distances if the laser turned by `shift` bins; infinite if the sweeps
/// hardly overlap.
double costOf(const std::vector<float>& before, const std::vector<float>& after, int shift) {
  float sum = 0.0F;
  int pairs = 0;
  for (int i = 0; i < kBins; ++i) {
    const float a = before[static_cast<std::size_t>((i + shift + kBins) % kBins)];
    const float b = after[static_cast<std::size_t>(i)];
    const float difference = std::abs(a - b);
    if (std::isnan(difference)) continue;
    sum += std::min(difference, kMaxCost);
    ++pairs;
  }
  if (pairs < kFewestPairs) return std::numeric_limits<double>::infinity();
  return static_cast<double>(sum) / pairs;
}

/// Position of the minimum of a parabola through three neighboring costs, in bins from the middle.
double refined(double left, double middle, double right) {
  const double curvature = left - 2.0 * middle + right;
  if (!(curvature > 0.0) || !std::isfinite(curvature)) return 0.0;
  return std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5);
}

}  // namespace

std::vector<float> rangesAround(const LaserScan& scan) {
  std::vector<float> bins(kBins, kNan);
  const auto farthest = static_cast<float>(scan.range_max);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (!(scan.ranges[i] < farthest)) continue;
    put(scan.angle_min + static_cast<double>(i) * scan.angle_increment, scan.ranges[i], bins);
  }
  return bins;
}

std::vector<float> rangesAround(const PointCloud& cloud) {
  constexpr float kLevel = 0.2F;  // slope; steeper beams hit floor and ceiling
  std::vector<float> bins(kBins, kNan);
  for (const PointCloud::Point& point : cloud.points) {
    const float range = std::hypot(point.x, point.y);
    if (!(std::abs(point.z) < kLevel * range)) continue;
    put(std::atan2(point.y, point.x), range, bins);
  }
  return bins;
}

std::optional<double> turnBetween(const std::vector<float>& before,
                                  const std::vector<float>& after) {
  std::vector<double> costs;
  for (int shift = -kMaxShift; shift <= kMaxShift; ++shift) {
    costs.push_back(costOf(before, after, shift));
  }
  const auto best = std::min_element(costs.begin(), costs.end());
  if (best == costs.begin() || best + 1 == costs.end()) return std::nullopt;
  std::vector<double> sorted = costs;
  std::nth_element(sorted.begin(), sorted.begin() + kMaxShift, sorted.end());
  const double typical = sorted[kMaxShift];
  if (!std::isfinite(typical) || *best > kDistinct * typical) return std::nullopt;
  const double bins = static_cast<double>(best - costs.begin()) - kMaxShift +
                      refined(*(best - 1), *best, *(best + 1));
  return bins * 2.0 * kPi / kBins;
}

}  // namespace kestrel
