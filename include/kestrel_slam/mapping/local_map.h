// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "kestrel_slam/map/submap.h"

namespace kestrel {

/// Which part of the map scans are matched against.
struct WindowConfig {
  /// false: the whole map, in one grid that grows. true: the scans that were inserted last.
  bool enabled = false;
  /// Length of a submap in insertions that constrain the pose in every direction.
  int submap_scans = 90;
  /// So many of the last insertions of a submap are also in the window of the next one.
  int overlap_scans = 30;
  /// An insertion with an unobservable direction counts only this much, so that the window is
  /// longer in corridors.
  double degenerate_weight = 0.4;
  /// Scans that are farther apart than this distance, and than this share of the median range,
  /// count more, so that a submap does not become too long.
  double scan_distance_m = 0.5, scan_distance_share = 0.15;
};

/// The map around the vehicle, in the local frame: the scans of the current submap and the last
/// ones of the submap before it. The frame never jumps: a pose graph corrects the poses of the
/// submaps.
///
/// Without a window there is one submap, which grows.
class LocalMap {
 public:
  LocalMap(const OccupancyGridConfig& grid, const SubmapOptions& options,
           const WindowConfig& window);

  /// A finished map, to which nothing is added.
  explicit LocalMap(Submap fixed);

  bool isFixed() const { return fixed_; }
  /// The map to match against.
  const Submap& current() const { return *current_; }
  Submap& current() { return *current_; }
  /// Number of the submap to which the next inserted scan belongs, from 0.
  std::uint32_t submap() const { return submap_; }

  /// Inserts the scan with this number. `degenerate`: a direction is unobservable.
  void insert(const PlanarScan& scan, const Pose2& local_T_base, bool new_view, bool degenerate);

  int scans() const { return scans_; }  ///< inserted so far
  /// Whether no scan of this laser was inserted. Its view may be missing where the vehicle begins.
  bool lacks(const std::string& source) const { return sources_.count(source) == 0; }
  std::size_t memoryBytes() const;

 private:
  void beginSubmap();
  double weightOf(const PlanarScan& scan, const Pose2& local_T_base, bool degenerate) const;

  OccupancyGridConfig grid_;
  SubmapOptions options_;
  WindowConfig window_;
  std::unique_ptr<Submap> current_;
  std::unique_ptr<Submap> next_;  ///< the last scans of the current submap, if it is nearly full
  std::uint32_t submap_ = 0;
  double length_ = 0.0;        ///< of the current submap, in insertions
  std::optional<Pose2> last_;  ///< of the last inserted scan
  int scans_ = 0;
  std::set<std::string> sources_;  ///< lasers of the inserted scans
  bool fixed_ = false;
};

}  // namespace kestrel
