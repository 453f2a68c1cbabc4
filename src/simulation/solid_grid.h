// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solids.h"

namespace kestrel {

/// A grid in the plane that speeds up ray casting. A ray tests only the solids in the cells that it
/// passes, in their order, and stops at the first hit.
class SolidGrid {
 public:
  SolidGrid(const std::vector<Box>& boxes, const std::vector<Cylinder>& cylinders);

  /// Updates `nearest` if the ray hits a solid closer than that.
  void intersect(const Ray& ray, RayHit& nearest) const;

 private:
  void setLayout();
  void fill();
  void intersectCell(std::size_t cell, const Ray& ray, RayHit& nearest) const;
  template <typename Solid>
  void addToCells(const Solid& solid, std::size_t number,
                  std::vector<std::vector<std::size_t>>& cells) const;

  std::vector<BoxSolid> boxes_;
  std::vector<CylinderSolid> cylinders_;
  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();  ///< lowest x and y, m
  double cell_size_ = 1.0;                            ///< m
  Eigen::Vector2i size_ = Eigen::Vector2i::Zero();    ///< in cells
  std::vector<std::size_t> first_;   ///< index in solids_ of each cell's first entry, and the end
  std::vector<std::size_t> solids_;  ///< numbers of solids: boxes first, then cylinders
};

}  // namespace kestrel
