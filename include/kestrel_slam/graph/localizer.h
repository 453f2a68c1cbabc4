// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "kestrel_slam/graph/place_finder.h"
#include "kestrel_slam/mapping/mapper.h"

namespace kestrel {

/// Tells where a vehicle is in a finished map, which does not change. While the pose is unknown, it
/// searches the whole map, some work with every scan, and measures the motion with a map of the
/// last scans. Deterministic, and its memory does not grow.
class Localizer {
 public:
  /// The pose is unknown at first.
  Localizer(const MapperConfig& config, Submap map,
            const RelocalizationConfig& relocalization = RelocalizationConfig());

  /// As Mapper::process. The state is lost while the pose is unknown, also after a gap in which the
  /// vehicle may have moved far; then the pose of the result is a guess.
  MapperResult process(const PlanarScan& scan,
                       const std::optional<Pose2>& odom_T_base = std::nullopt);

  /// A user says where the vehicle is.
  void setPose(const Pose2& map_T_base);
  /// Goes on where `before` is, whose map has grown to this one, and has moved by `after_T_before`
  /// there. While the matching goes on, the whole map is searched for a place that explains the
  /// scans better.
  void continueFrom(const Localizer& before, const Pose2& after_T_before);
  /// The pose is unknown: search the whole map.
  void relocalize();
  /// After a gap: the motion is unknown, but the pose may still be right.
  void restartMotion();

  bool isLost() const { return lost_; }
  /// Of the last search while lost.
  const RelocalizationAnswer& answer() const { return finder_.answer(); }
  const Mapper& mapper() const { return tracker_; }
  bool takeChangedTiles(std::size_t max_tiles, std::vector<TileImage>& images) {
    return tracker_.takeChangedTiles(max_tiles, images);
  }
  std::size_t memoryBytes() const;

 private:
  MapperResult track(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base);
  MapperResult doubt(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                     const MapperResult& result);
  bool mustCheck(const Pose2& map_T_base) const;
  std::int64_t workFor(const PlanarScan& scan) const;
  double secondsSince(const PlanarScan& scan) const;
  MapperResult search(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base);
  std::optional<MapperResult> confirm(const PlanarScan& scan,
                                      const std::optional<Pose2>& odom_T_base, const Pose2& pose);
  void beginAnew(const Pose2& local_T_base);
  void lose(const Pose2& map_T_base);

  MapperConfig local_config_;
  Mapper tracker_;
  GlobalMap global_;
  PlaceFinder finder_;
  double min_fit_;                 ///< of a scan where the vehicle was found, 0 to 1
  std::unique_ptr<Mapper> local_;  ///< while lost: measures the motion
  bool lost_ = true;
  std::optional<Pose2> check_from_;  ///< where it went on in a grown map, until it is checked
  Pose2 guess_;                      ///< map_T_local while lost: where the vehicle was last seen
  std::optional<double> fit_time_;   ///< of the last scan that fitted well, s
  std::optional<double> time_;       ///< of the last scan, s
};

}  // namespace kestrel
