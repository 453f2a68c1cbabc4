// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace kestrel {

/// A sweep of a 3D lidar, in the sensor frame.
struct PointCloud {
  struct Point {
    float x, y, z;  ///< m; NaN: no return (organized clouds)
    float time;     ///< s after `stamp`; negative if `stamp` is the end of the sweep
  };
  double stamp = 0.0;  ///< as recorded, s
  std::vector<Point> points;
  std::string time_problem;  ///< why the recorded times of the points are not used; "" if they are
  std::string frame;         ///< of the lidar; clouds of the same frame come from the same source
};

}  // namespace kestrel
