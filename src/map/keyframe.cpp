// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/keyframe.h"

namespace kestrel {

PlanarScan Keyframe::planarScan() const {
  PlanarScan result;
  result.stamp = stamp;
  result.time = time;
  result.height = height;
  result.rays = scan.rays();
  return result;
}

}  // namespace kestrel
