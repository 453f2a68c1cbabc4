// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/local_map.h"

#include <algorithm>
#include <utility>

namespace kestrel {

LocalMap::LocalMap(const OccupancyGridConfig& grid, const SubmapOptions& options,
                   const WindowConfig& window)
    : grid_(grid),
      options_(options),
      window_(window),
      current_(std::make_unique<Submap>(grid, options)) {}

LocalMap::LocalMap(Submap fixed)
    : current_(std::make_unique<Submap>(std::move(fixed))),
      scans_(current_->scans()),
      fixed_(true) {}

void LocalMap::insert(const PlanarScan& scan, const Pose2& local_T_base, bool new_view,
                      bool degenerate) {
  if (window_.enabled && length_ >= window_.submap_scans) beginSubmap();
  if (window_.enabled && !next_ && length_ >= window_.submap_scans - window_.overlap_scans)
    next_ = std::make_unique<Submap>(grid_, options_);
  const auto number = static_cast<std::uint32_t>(scans_++);
  if (next_ && !options_.stitching) {
    // Both submaps have the local frame: the beams are traced once.
    const FreeCells free = current_->grid().freeCells(scan, local_T_base);
    current_->insert(scan, local_T_base, new_view, number, free);
    next_->insert(scan, local_T_base, new_view, number, free);
  } else {
    current_->insert(scan, local_T_base, new_view, number);
    if (next_) next_->insert(scan, local_T_base, new_view, number);
  }
  length_ += weightOf(scan, local_T_base, degenerate);
  // A long step must not end the submap before the next one has a scan.
  if (!next_) length_ = std::min<double>(length_, window_.submap_scans - 1);
  last_ = local_T_base;
  sources_.insert(scan.source);
}

/// Length of the submap that a scan adds, in scans that are near each other.
double LocalMap::weightOf(const PlanarScan& scan, const Pose2& local_T_base,
                          bool degenerate) const {
  std::vector<float> ranges;
  for (const PlanarRay& ray : scan.rays) {
    if (ray.hit) ranges.push_back((ray.end - ray.origin).norm());
  }
  double weight = degenerate ? window_.degenerate_weight : 1.0;
  if (!last_ || ranges.empty()) return weight;
  const auto median = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::nth_element(ranges.begin(), median, ranges.end());
  const double near_m =
      std::max(window_.scan_distance_m, window_.scan_distance_share * static_cast<double>(*median));
  return weight * std::max(1.0, last_->between(local_T_base).distance() / near_m);
}

/// The window keeps only the last scans of the submap.
void LocalMap::beginSubmap() {
  current_ = std::move(next_);
  ++submap_;
  length_ = 0.0;
}

std::size_t LocalMap::memoryBytes() const {
  return current_->memoryBytes() + (next_ ? next_->memoryBytes() : 0);
}

}  // namespace kestrel
