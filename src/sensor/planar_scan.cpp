// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

Points hitsOf(const PlanarScan& scan) {
  Points points;
  points.reserve(scan.rays.size());
  for (const PlanarRay& ray : scan.rays) {
    if (ray.hit) points.push_back(ray.end);
  }
  return points;
}

}  // namespace kestrel
