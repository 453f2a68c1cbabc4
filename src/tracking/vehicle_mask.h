// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// Finds returns from the vehicle itself: a wheel, an arm or a person who rides on it. In the frame
/// of the vehicle they stay where they are while everything else moves past.
class VehicleMask {
 public:
  VehicleMask();

  /// For each ray, whether its return moves with the vehicle. `odom_T_base`: pose at the scan.
  std::vector<bool> update(const PlanarScan& scan, const Pose2& odom_T_base);

 private:
  static constexpr int kBins = 720;  ///< of half a degree
  struct Bin {
    float range = -1.0F;    ///< of the return that stays, m; negative: none
    float traveled = 0.0F;  ///< by the vehicle since then, m
  };

  std::vector<Bin> bins_;
  Pose2 last_;
  bool has_last_ = false;
};

}  // namespace kestrel
