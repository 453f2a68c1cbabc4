// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/picture_map.h"

#include <algorithm>

namespace kestrel {
namespace {

/// The cells of the picture are certain: so many insertions make them so.
constexpr int kInsertions = 3;
/// Rows that are inserted at once, which limits the memory.
constexpr int kRows = 64;
/// Cells that follow one another in a scan must not look like a wall in the order of the rows.
constexpr std::size_t kStride = 97;

bool isOccupied(const MapSnapshot& map, int column, int row) {
  if (column < 0 || row < 0 || column >= map.width || row >= map.height) return false;
  return map.at(column, row) == MapSnapshot::kOccupied;
}

/// Inside of a thick wall nothing can be seen.
bool isWall(const MapSnapshot& map, int column, int row) {
  return isOccupied(map, column, row) &&
         !(isOccupied(map, column - 1, row) && isOccupied(map, column + 1, row) &&
           isOccupied(map, column, row - 1) && isOccupied(map, column, row + 1));
}

Eigen::Vector2f centerOf(const MapSnapshot& map, int column, int row) {
  return Eigen::Vector2d(map.origin_x + (column + 0.5) * map.resolution_m,
                         map.origin_y + (row + 0.5) * map.resolution_m)
      .cast<float>();
}

std::vector<PlanarRay> wallsOf(const MapSnapshot& map, int first, int last) {
  std::vector<PlanarRay> cells, result;
  for (int row = first; row < last; ++row) {
    for (int column = 0; column < map.width; ++column) {
      const Eigen::Vector2f center = centerOf(map, column, row);
      if (isWall(map, column, row)) cells.push_back({center, center, true});
    }
  }
  for (std::size_t offset = 0; offset < kStride; ++offset) {
    for (std::size_t i = offset; i < cells.size(); i += kStride) result.push_back(cells[i]);
  }
  return result;
}

void addFreeOf(const MapSnapshot& map, int row, std::vector<PlanarRay>& rays) {
  for (int column = 0; column < map.width; ++column) {
    const int begin = column;
    while (column < map.width && map.at(column, row) == MapSnapshot::kFree) ++column;
    if (column > begin)
      rays.push_back({centerOf(map, begin, row), centerOf(map, column - 1, row), false});
  }
}

}  // namespace

Submap submapOf(const MapSnapshot& picture, OccupancyGridConfig config) {
  config.resolution_m = picture.resolution_m;
  Submap result(config);
  for (int first = 0; first < picture.height; first += kRows) {
    const int last = std::min(first + kRows, picture.height);
    PlanarScan scan;
    scan.rays = wallsOf(picture, first, last);
    for (int row = first; row < last; ++row) addFreeOf(picture, row, scan.rays);
    constexpr std::uint32_t kNumber = 0;
    for (int i = 0; i < kInsertions; ++i) result.insert(scan, Pose2(), true, kNumber);
  }
  return result;
}

}  // namespace kestrel
