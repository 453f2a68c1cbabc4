// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/surfel_field.h"
#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

/// Four floats in one vector register on x86-64 and ARM, without special compiler flags.
using Lanes = Eigen::Array<float, 4, 1>;
constexpr std::size_t kLanes = 4;

/// The largest integers not above four values, as floorToInt.
inline FourInts floorToInt(const Lanes& values) {
  // Vector types of GCC and Clang: Eigen has no vector instructions for this without SSE 4.
  using Floats = float __attribute__((vector_size(16)));
  Floats floats;
  std::memcpy(&floats, values.data(), sizeof(floats));
  const FourInts truncated = __builtin_convertvector(floats, FourInts);
  // A comparison is -1 where it is true.
  return truncated + (floats < __builtin_convertvector(truncated, Floats));
}

/// Four points of a scan with their nearest surfels, for sums over a scan. A point without a surfel
/// within reach, and lanes past the end of the scan, have a surfel of zeros.
struct SurfelLanes {
  Lanes rx,
      ry;  ///< the points rotated to the map frame, but not translated, m [Kohlbrecher 2011, eq. 8]
  Lanes px, py;         ///< the points in the map frame, m
  Lanes ex, ey;         ///< from the wall of the surfel to the point, m
  Lanes a11, a12, a22;  ///< information matrices of the surfels
  std::array<const Surfel*, kLanes> surfels;

  Lanes distance2() const { return ex * (a11 * ex + a12 * ey) + ey * (a12 * ex + a22 * ey); }

  /// 1 if there is a surfel (its trace is at least 1), else 0.
  Lanes hasSurfel() const { return (a11 + a22).min(1.0F); }
};

/// The values of four surfels that a match needs. They lie side by side in a surfel, so that a
/// surfel is read with one instruction instead of five, and the four are transposed.
inline void readSurfels(const std::array<const Surfel*, kLanes>& surfels, Lanes& x, Lanes& y,
                        Lanes& a11, Lanes& a12, Lanes& a22) {
  constexpr std::size_t kFirst = offsetof(Surfel, on_wall);
  static_assert(offsetof(Surfel, a11) == kFirst + 2 * sizeof(float) &&
                    offsetof(Surfel, a12) == kFirst + 3 * sizeof(float),
                "on_wall, a11 and a12 lie side by side");
  Eigen::Matrix4f values;
  for (std::size_t i = 0; i < kLanes; ++i) {
    std::memcpy(values.data() + kLanes * i, reinterpret_cast<const char*>(surfels[i]) + kFirst,
                kLanes * sizeof(float));
  }
  values.transposeInPlace();
  x = values.col(0), y = values.col(1), a11 = values.col(2), a12 = values.col(3);
  a22 = Lanes(surfels[0]->a22, surfels[1]->a22, surfels[2]->a22, surfels[3]->a22);
}

/// The surfels of the points at the last pose of a descent. The last steps of a descent are so
/// short that most points stay in their cells.
class LastSurfels {
 public:
  explicit LastSurfels(std::size_t points) : fours_((points + kLanes - 1) / kLanes) {}

  /// The surfels nearest to the cells of the four points from `first` on.
  const std::array<const Surfel*, kLanes>& nearest(const SurfelField& surface, std::size_t first,
                                                   const FourInts& x, const FourInts& y) {
    Four& four = fours_[first / kLanes];
    const FourInts moved = (four.x ^ x) | (four.y ^ y);
    std::array<std::uint64_t, 2> halves;
    std::memcpy(halves.data(), &moved, sizeof(moved));
    if (four.surfels[0] == nullptr || (halves[0] | halves[1]) != 0U)
      four = {x, y, surface.nearestOrZeros(x, y)};
    return four.surfels;
  }

 private:
  struct Four {
    FourInts x{}, y{};
    std::array<const Surfel*, kLanes> surfels{};
  };
  std::vector<Four> fours_;
};

/// Calls `visit(lanes, count)` for every four points of a scan at `map_T_base`. In the last call
/// only the first `count` lanes are points. `nearest(first, columns, rows)`: the surfels nearest to
/// the cells of the points from `first` on.
template <typename Points, typename Nearest, typename Visit>
inline void forEachLanes(const SurfelField& surface, const Points& points, const Pose2& map_T_base,
                         Nearest nearest, Visit visit) {
  const auto c = static_cast<float>(std::cos(map_T_base.yaw));
  const auto s = static_cast<float>(std::sin(map_T_base.yaw));
  const auto x = static_cast<float>(map_T_base.x), y = static_cast<float>(map_T_base.y);
  const float cells_per_m = surface.cellsPerMeter();
  SurfelLanes lanes;
  std::array<Eigen::Vector2f, kLanes> last;
  for (std::size_t first = 0; first < points.size(); first += kLanes) {
    const std::size_t count = std::min(kLanes, points.size() - first);
    const Eigen::Vector2f* four = points.data() + first;
    if (count < kLanes) {
      last.fill(four[count - 1]);
      std::copy_n(four, count, last.begin());
      four = last.data();
    }
    const Lanes sx(four[0].x(), four[1].x(), four[2].x(), four[3].x());
    const Lanes sy(four[0].y(), four[1].y(), four[2].y(), four[3].y());
    lanes.rx = c * sx - s * sy;
    lanes.ry = s * sx + c * sy;
    lanes.px = x + lanes.rx;
    lanes.py = y + lanes.ry;
    const FourInts columns = floorToInt(Lanes(lanes.px * cells_per_m));
    const FourInts rows = floorToInt(Lanes(lanes.py * cells_per_m));
    lanes.surfels = nearest(first, columns, rows);
    // Lanes past the end repeat the last point, but they have no surfel.
    for (std::size_t i = count; i < kLanes; ++i) lanes.surfels[i] = &SurfelField::zeros();
    Lanes wall_x, wall_y;
    readSurfels(lanes.surfels, wall_x, wall_y, lanes.a11, lanes.a12, lanes.a22);
    lanes.ex = lanes.px - wall_x;
    lanes.ey = lanes.py - wall_y;
    visit(lanes, count);
  }
}

/// The same with the surfels of `surface`.
template <typename Points, typename Visit>
inline void forEachLanes(const SurfelField& surface, const Points& points, const Pose2& map_T_base,
                         Visit visit) {
  const auto nearest = [&](std::size_t /*first*/, const FourInts& columns, const FourInts& rows) {
    return surface.nearestOrZeros(columns, rows);
  };
  forEachLanes(surface, points, map_T_base, nearest, visit);
}

/// See gauss_newton.h. With the surfels of the last pose of the descent.
NormalEquations linearizeDistance(const SurfelField& surface, const Points& points,
                                  const Pose2& map_T_base, float scale_m,
                                  LastSurfels& last_surfels);

}  // namespace kestrel
