// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solids.h"

namespace kestrel {

/// Which boxes and cylinders a ray may meet, cell by cell of a grid in the plane: a ray looks only
/// at what stands in the cells that it passes, in their order, and stops at the first that it
/// meets.
class SolidGrid {
 public:
  SolidGrid(const std::vector<Box>& boxes, const std::vector<Cylinder>& cylinders);

  /// Updates `nearest` where the ray meets something before.
  void meet(const Ray& ray, RayHit& nearest) const;

 private:
  void layOut();
  void fill();
  void meetCell(std::size_t cell, const Ray& ray, RayHit& nearest) const;
  template <typename Solid>
  void addToCells(const Solid& solid, std::size_t number,
                  std::vector<std::vector<std::size_t>>& cells) const;

  std::vector<BoxSolid> boxes_;
  std::vector<CylinderSolid> cylinders_;
  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();  ///< lowest x and y, m
  double cell_size_ = 1.0;                            ///< m
  Eigen::Vector2i size_ = Eigen::Vector2i::Zero();    ///< in cells
  std::vector<std::size_t> first_;                    ///< of each cell in solids_, and the end
  std::vector<std::size_t> solids_;                   ///< numbers: boxes, then cylinders
};

}  // namespace kestrel
