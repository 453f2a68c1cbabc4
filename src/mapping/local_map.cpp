// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/local_map.h"

#include <utility>

namespace kestrel {

LocalMap::LocalMap(const OccupancyGridConfig& grid, const SubmapOptions& options,
                   const WindowConfig& window)
    : grid_(grid),
      options_(options),
      window_(window),
      current_(std::make_shared<Submap>(grid, options)),
      next_(nullptr) {}

std::shared_ptr<const Submap> LocalMap::insert(const PlanarScan& scan, const Pose2& local_T_base,
                                               bool new_view, bool degenerate) {
  std::shared_ptr<const Submap> finished;
  if (window_.enabled && length_ >= window_.submap_scans) finished = beginSubmap();
  if (window_.enabled && !next_ && length_ >= window_.submap_scans - window_.overlap_scans)
    next_ = std::make_shared<Submap>(grid_, options_);
  const auto number = static_cast<std::uint32_t>(scans_++);
  current_->insert(scan, local_T_base, new_view, number);
  if (next_) next_->insert(scan, local_T_base, new_view, number);
  length_ += degenerate ? window_.degenerate_weight : 1.0;
  return finished;
}

/// The window forgets the submap before the last one.
std::shared_ptr<const Submap> LocalMap::beginSubmap() {
  std::shared_ptr<const Submap> finished = std::exchange(current_, std::exchange(next_, nullptr));
  ++submap_;
  length_ = 0.0;
  return finished;
}

std::size_t LocalMap::memoryBytes() const {
  return current_->memoryBytes() + (next_ ? next_->memoryBytes() : 0);
}

}  // namespace kestrel
