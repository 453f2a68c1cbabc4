// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "kestrel_slam/sensor/laser_scan.h"

namespace kestrel {

/// Finds the beams of one laser that hit the vehicle itself: landing gear, arms, rotor guards.
/// While the rest of the view changes, they keep their range. They move with the vehicle, so that
/// a match with them stands still.
class VehicleReturns {
 public:
  /// Call it with every scan, in the order of time.
  void observe(const LaserScan& scan);

  /// Marks the beams of a scan that hit the vehicle. `mask`: one entry for each beam, or empty,
  /// which is no mark at all.
  void addTo(const LaserScan& scan, std::vector<bool>& mask) const;

 private:
  static constexpr std::size_t kBins = 360;
  using Ranges = std::array<float, kBins>;

  /// What a direction showed nearby.
  struct Nearby {
    float range_m = 0.0F;  ///< mean over the views
    int views = 0;         ///< different views in which it had this range
  };

  static Ranges nearestOf(const LaserScan& scan);
  bool isNewView(const Ranges& ranges) const;

  Ranges view_{};  ///< the last view that counted
  bool has_view_ = false;
  std::array<Nearby, kBins> nearby_{};
  std::size_t found_ = 0;  ///< number of directions in which a part of the vehicle is seen
};

}  // namespace kestrel
