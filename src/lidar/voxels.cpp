// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/lidar/voxels.h"

namespace kestrel {
namespace {

constexpr int kBits = 21;  ///< of each coordinate in a key
constexpr std::size_t kSmallest = 64;

std::uint64_t keyOf(const GridIndex<3>& index) {
  constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1U;
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) key = key << kBits | (static_cast<std::uint64_t>(index(i)) & kMask);
  return key;
}

/// Mixes the bits of a key [Stafford 2011, variant 13 of the finalizer of MurmurHash3].
std::uint64_t mixed(std::uint64_t key) {
  key = (key ^ (key >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  key = (key ^ (key >> 27U)) * 0x94d049bb133111ebULL;
  return key ^ (key >> 31U);
}

}  // namespace

VoxelTable::VoxelTable(std::size_t expected) {
  std::size_t slots = kSmallest;
  while (slots < 2 * expected) slots *= 2;
  entries_.resize(slots);
}

std::size_t VoxelTable::slotOf(std::uint64_t key) const {
  const std::size_t mask = entries_.size() - 1;
  std::size_t slot = static_cast<std::size_t>(mixed(key)) & mask;
  while (entries_[slot].key != kEmpty && entries_[slot].key != key) slot = (slot + 1) & mask;
  return slot;
}

std::uint32_t VoxelTable::numberOf(const GridIndex<3>& index) {
  const std::uint64_t key = keyOf(index);
  std::size_t slot = slotOf(key);
  if (entries_[slot].key == key) return entries_[slot].number;
  if (2 * (size_ + 1) > entries_.size()) {
    grow();
    slot = slotOf(key);
  }
  entries_[slot] = {key, static_cast<std::uint32_t>(size_)};
  return static_cast<std::uint32_t>(size_++);
}

std::uint32_t VoxelTable::find(const GridIndex<3>& index) const {
  const std::uint64_t key = keyOf(index);
  const Entry& entry = entries_[slotOf(key)];
  return entry.key == key ? entry.number : kNone;
}

void VoxelTable::grow() {
  std::vector<Entry> old(2 * entries_.size());
  old.swap(entries_);
  for (const Entry& entry : old) {
    if (entry.key != kEmpty) entries_[slotOf(entry.key)] = entry;
  }
}

void PointSums::add(const Eigen::Vector3d& point) {
  count += 1.0;
  const Eigen::Vector3d before = point - mean;
  mean += before / count;
  spread += before * (point - mean).transpose();
}

void PointSums::add(const PointSums& other) {
  if (!(other.count > 0.0)) return;
  const double total = count + other.count;
  const Eigen::Vector3d apart = other.mean - mean;
  spread += other.spread + apart * apart.transpose() * (count * other.count / total);
  mean += apart * (other.count / total);
  count = total;
}

GridIndex<3> voxelIndexOf(const Eigen::Vector3f& point, double resolution) {
  const auto inverse = static_cast<float>(1.0 / resolution);
  return {floorToInt(point.x() * inverse), floorToInt(point.y() * inverse),
          floorToInt(point.z() * inverse)};
}

Voxels voxelize(const std::vector<Eigen::Vector3f>& points, const std::vector<bool>& use,
                double resolution) {
  Voxels voxels;
  voxels.voxel_of.assign(points.size(), VoxelTable::kNone);
  VoxelTable table(points.size() / 4);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!use.empty() && !use[i]) continue;
    const GridIndex<3> index = voxelIndexOf(points[i], resolution);
    const std::uint32_t number = table.numberOf(index);
    if (number == voxels.index.size()) {
      voxels.index.push_back(index);
      voxels.sums.emplace_back();
    }
    voxels.voxel_of[i] = number;
    voxels.sums[number].add(points[i].cast<double>());
  }
  return voxels;
}

}  // namespace kestrel
