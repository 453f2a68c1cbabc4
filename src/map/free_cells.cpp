// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/free_cells.h"

#include "ray_run.h"

namespace kestrel {

FreeCells::FreeCells(const PlanarScan& scan, const Pose2& map_T_base, float cells_per_m,
                     std::size_t limit_bytes)
    : tiles_(limit_bytes) {
  const BeamsInCells in_cells(map_T_base, cells_per_m);
  for (const PlanarRay& ray : scan.rays) {
    if (ray.no_return || ray.presumed) continue;
    forEachRun(in_cells(ray.origin), in_cells(ray.end), [this](const RayRun& run) {
      const Cell cell = run.cell();
      Tile* tile = tiles_.find(cell);
      if (tile == nullptr) {
        tile = tiles_.obtain(cell);
        if (tile == nullptr) {
          full_ = true;
          return true;
        }
        tile->corner = {cell.x & ~(kTileSide - 1), cell.y & ~(kTileSide - 1)};
        in_order_.push_back(tile);
      }
      mark(run, run.count, tile->rows);
      return true;
    });
  }
}

}  // namespace kestrel
