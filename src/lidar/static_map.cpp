// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/lidar/static_map.h"

#include <octomap/OcTree.h>

#include <cstring>
#include <sstream>

namespace kestrel {

void StaticMap::add(const CloudTracker& tracker) {
  const MotionGrid<3>& grid = tracker.grid();
  const Eigen::Vector3f lidar = tracker.pose().translation().cast<float>();
  for (const SurfaceCell& cell : tracker.surfaces().cells()) {
    const std::uint32_t number = table_.numberOf(voxelIndexOf(cell.mean, resolution_));
    if (number == points_.size()) {
      points_.push_back(cell.mean);
      seen_from_.push_back(lidar);
      occupied_.push_back(true);
    }
    points_[number] = cell.mean;
    occupied_[number] = grid.staticState(grid.indexOf(cell.mean)) != CellState::kFree;
  }
}

std::vector<Eigen::Vector3f> StaticMap::points() const {
  std::vector<Eigen::Vector3f> kept;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (occupied_[i]) kept.push_back(points_[i]);
  }
  return kept;
}

std::string StaticMap::pcd() const {
  const std::vector<Eigen::Vector3f> kept = points();
  std::ostringstream header;
  header << "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\n"
         << "TYPE F F F\nCOUNT 1 1 1\nWIDTH " << kept.size()
         << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << kept.size() << "\nDATA binary\n";
  std::string content = header.str();
  const std::size_t start = content.size(), size = 3 * sizeof(float);
  content.resize(start + kept.size() * size);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    std::memcpy(&content[start + i * size], kept[i].data(), size);
  }
  return content;
}

std::string StaticMap::octomap() const {
  octomap::OcTree tree(resolution_);
  const auto toPoint = [](const Eigen::Vector3f& p) {
    return octomap::point3d(p.x(), p.y(), p.z());
  };
  octomap::KeyRay ray;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!tree.computeRayKeys(toPoint(seen_from_[i]), toPoint(points_[i]), ray)) continue;
    for (const octomap::OcTreeKey& key : ray) {
      if (tree.search(key) == nullptr) tree.updateNode(key, false, true);
    }
  }
  for (const Eigen::Vector3f& point : points()) {
    tree.setNodeValue(toPoint(point), tree.getClampingThresMaxLog(), true);
  }
  tree.updateInnerOccupancy();
  std::ostringstream out;
  tree.writeBinary(out);
  return out.str();
}

}  // namespace kestrel
