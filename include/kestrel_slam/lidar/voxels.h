// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kestrel_slam/tracking/cell_map.h"

namespace kestrel {

/// Numbers the voxels of space in the order in which they are first asked for. A hash table with
/// open addressing: clouds have a hundred thousand points.
class VoxelTable {
 public:
  explicit VoxelTable(std::size_t expected = 0);

  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  /// The number of a voxel; a new voxel gets the next number.
  std::uint32_t numberOf(const GridIndex<3>& index);
  /// kNone if the voxel has no number yet.
  std::uint32_t find(const GridIndex<3>& index) const;
  std::size_t size() const { return size_; }
  std::size_t memoryBytes() const { return entries_.size() * sizeof(Entry); }

 private:
  struct Entry {
    std::uint64_t key = kEmpty;
    std::uint32_t number = 0;
  };
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};

  std::size_t slotOf(std::uint64_t key) const;
  void grow();

  std::vector<Entry> entries_;
  std::size_t size_ = 0;
};

/// Number, mean and spread of points.
struct PointSums {
  double count = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();  ///< sum of the products of the deviations

  void add(const Eigen::Vector3d& point);
  void add(const PointSums& other);
};

/// The points of a cloud by voxel.
struct Voxels {
  std::vector<GridIndex<3>> index;
  std::vector<PointSums> sums;          ///< the mean is the voxel's centroid [Siew 2018, sec. V]
  std::vector<std::uint32_t> voxel_of;  ///< of each point; VoxelTable::kNone if it is not used
};

GridIndex<3> voxelIndexOf(const Eigen::Vector3f& point, double resolution);

/// Sorts those points into voxels for which `use` is true (empty: all).
Voxels voxelize(const std::vector<Eigen::Vector3f>& points, const std::vector<bool>& use,
                double resolution);

}  // namespace kestrel
