// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/vehicle_returns.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr float kReachM = 1.0F;  ///< parts of the vehicle are nearer to its laser
constexpr float kSameM = 0.03F;  ///< noise of a laser at short range
/// A range that differs by more shows that the view has changed. A part that keeps its range within
/// kSameM while others change so much moves with the laser.
constexpr float kChangedM = 0.1F;
/// In so many views the range must have been the same. Nobody flies along a wall so exactly while
/// the view changes so often.
constexpr int kViews = 20;
/// In a new view so much of what is compared has changed: the vehicle has turned, or has gone
/// somewhere else. While it follows a corridor, the walls beside it keep their range, too.
constexpr double kChangedShare = 0.8;
constexpr std::size_t kMinCompared = 10;
constexpr float kNone = std::numeric_limits<float>::infinity();

bool isSame(float range, float other) { return std::abs(range - other) < kSameM; }

/// The directions of the beams of a scan, in bins of a full turn.
class BeamBins {
 public:
  BeamBins(const LaserScan& scan, std::size_t bins)
      : bins_(static_cast<double>(bins)),
        place_(bins_ * wrapped(scan.angle_min / (2.0 * kPi))),
        step_(bins_ * wrapped(scan.angle_increment / (2.0 * kPi))) {}

  std::size_t next() {
    const double place = place_;
    place_ += step_;
    if (place_ >= bins_) place_ -= bins_;
    return std::min(static_cast<std::size_t>(place), static_cast<std::size_t>(bins_) - 1);
  }

 private:
  static double wrapped(double turns) { return turns - std::floor(turns); }

  double bins_, place_, step_;
};

}  // namespace

VehicleReturns::Ranges VehicleReturns::nearestOf(const LaserScan& scan) {
  Ranges nearest;
  nearest.fill(kNone);
  BeamBins bins(scan, kBins);
  const auto range_max = static_cast<float>(scan.range_max);
  for (const float range : scan.ranges) {
    float& place = nearest[bins.next()];
    if (range > 0.0F && range < range_max) place = std::min(place, range);
  }
  return nearest;
}

/// Only what is not near is compared: most of it is not the vehicle.
bool VehicleReturns::isNewView(const Ranges& ranges) const {
  std::size_t compared = 0, changed = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    if (ranges[i] < kReachM || view_[i] < kReachM) continue;
    if (ranges[i] == kNone || view_[i] == kNone) continue;
    ++compared;
    changed += std::abs(ranges[i] - view_[i]) > kChangedM ? 1U : 0U;
  }
  return compared >= kMinCompared &&
         static_cast<double>(changed) > kChangedShare * static_cast<double>(compared);
}

void VehicleReturns::observe(const LaserScan& scan) {
  const Ranges ranges = nearestOf(scan);
  if (has_view_ && !isNewView(ranges)) return;
  view_ = ranges;
  has_view_ = true;
  found_ = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    // Where the laser sees past a part, the part may still be there.
    Nearby& nearby = nearby_[i];
    if (ranges[i] < kReachM) {
      if (!isSame(ranges[i], nearby.range_m)) nearby = {};
      nearby.views = std::min(nearby.views + 1, kViews);
      nearby.range_m += (ranges[i] - nearby.range_m) / static_cast<float>(nearby.views);
    }
    found_ += nearby.views == kViews ? 1U : 0U;
  }
}

void VehicleReturns::addTo(const LaserScan& scan, std::vector<bool>& mask) const {
  if (found_ == 0) return;
  mask.resize(scan.ranges.size());
  BeamBins bins(scan, kBins);
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const Nearby& nearby = nearby_[bins.next()];
    if (nearby.views == kViews && isSame(scan.ranges[i], nearby.range_m)) mask[i] = true;
  }
}

}  // namespace kestrel
