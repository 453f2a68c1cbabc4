// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/tile_map.h"

namespace kestrel {

/// Cells beyond this are the result of wrong poses: 26 000 km at 5 cm.
constexpr float kMaxCellCoordinate = 5e8F;

/// The part of a beam in one tile: one cell for each step along the longer axis. 32.32 fixed point,
/// in cells.
struct RayRun {
  std::int64_t x, y, step_x, step_y;
  int count;

  Cell cell() const { return {static_cast<int>(x >> 32), static_cast<int>(y >> 32)}; }
};

/// Marks the first `count` cells of a run.
inline void mark(const RayRun& run, int count, std::array<std::uint32_t, kTileSide>& rows) {
  // The cell within the tile in the highest bits: what goes beyond the tile falls out.
  constexpr int kUp = 32 - kTileShift, kDown = 64 - kTileShift;
  auto x = static_cast<std::uint64_t>(run.x) << kUp, y = static_cast<std::uint64_t>(run.y) << kUp;
  const auto step_x = static_cast<std::uint64_t>(run.step_x) << kUp;
  const auto step_y = static_cast<std::uint64_t>(run.step_y) << kUp;
  const auto mark_next = [&] {
    rows[y >> kDown] |= 1U << (x >> kDown);
    x += step_x, y += step_y;
  };
  if (count % 2 != 0) mark_next();
  for (int k = count / 2; k > 0; --k) {
    mark_next();
    mark_next();
  }
}

/// Number of points x, x + step, … in the tile of the first one.
inline std::int64_t stepsInTile(std::int64_t x, std::int64_t step) {
  constexpr std::int64_t kSide = std::int64_t{kTileSide} << 32;
  const std::int64_t inside = x & (kSide - 1);
  if (step > 0) return (kSide - 1 - inside) / step + 1;
  if (step < 0) return inside / -step + 1;
  return std::numeric_limits<int>::max();
}

/// Calls `visit(run)` for the parts of a beam, until it returns false. `from` and `to` are in
/// cells. The last cell is left out.
template <typename Visit>
void forEachRun(const Eigen::Vector2f& from, const Eigen::Vector2f& to, Visit visit) {
  if (!(from.cwiseAbs().maxCoeff() < kMaxCellCoordinate) ||
      !(to.cwiseAbs().maxCoeff() < kMaxCellCoordinate))
    return;
  constexpr double kOne = 4294967296.0;
  const Eigen::Vector2d difference = (to - from).cast<double>();
  int left = static_cast<int>(difference.cwiseAbs().maxCoeff());
  if (left == 0) return;
  const double scale = kOne / difference.cwiseAbs().maxCoeff();
  RayRun run{static_cast<std::int64_t>(static_cast<double>(from.x()) * kOne),
             static_cast<std::int64_t>(static_cast<double>(from.y()) * kOne),
             static_cast<std::int64_t>(difference.x() * scale),
             static_cast<std::int64_t>(difference.y() * scale), 0};
  for (; left > 0; left -= run.count) {
    const std::int64_t inside =
        std::min(stepsInTile(run.x, run.step_x), stepsInTile(run.y, run.step_y));
    run.count = static_cast<int>(std::min<std::int64_t>(left, inside));
    if (!visit(static_cast<const RayRun&>(run))) return;
    run.x += run.count * run.step_x, run.y += run.count * run.step_y;
  }
}

/// The beams of a scan in the map frame, in cells.
class BeamsInCells {
 public:
  BeamsInCells(const Pose2& map_T_base, float cells_per_m)
      : c_(static_cast<float>(std::cos(map_T_base.yaw))),
        s_(static_cast<float>(std::sin(map_T_base.yaw))),
        t_(map_T_base.translation().cast<float>()),
        cells_per_m_(cells_per_m) {}

  Eigen::Vector2f operator()(const Eigen::Vector2f& p) const {
    return Eigen::Vector2f(t_.x() + c_ * p.x() - s_ * p.y(), t_.y() + s_ * p.x() + c_ * p.y()) *
           cells_per_m_;
  }

 private:
  float c_, s_;
  Eigen::Vector2f t_;
  float cells_per_m_;
};

}  // namespace kestrel
