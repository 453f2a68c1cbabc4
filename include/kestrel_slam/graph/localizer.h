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

/// Tells where a vehicle is in a finished map, which does not change. Deterministic, and its memory
/// does not grow.
///
/// Tracking: every scan is matched with the map. Following: a scan does not clearly fit, for
/// example because the place is not in the map; then a map of the last scans measures the motion,
/// and the finished map corrects the pose only where it agrees with this motion. Lost: the pose is
/// unknown; the whole map is searched, some work with every scan.
class Localizer {
 public:
  /// The pose is unknown at first.
  Localizer(const MapperConfig& config, Submap map,
            const RelocalizationConfig& relocalization = RelocalizationConfig());

  /// As Mapper::process. The state is lost while the pose is unknown; then the pose of the result
  /// is a guess.
  MapperResult process(const PlanarScan& scan,
                       const std::optional<Pose2>& odom_T_base = std::nullopt);

  /// A user says where the vehicle is.
  void setPose(const Pose2& map_T_base);
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
  struct Known {  ///< where the vehicle was last known to be: in the map, and in the local map
    UncertainPose in_map, in_local;
  };

  MapperResult track(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base);
  bool isClear(const MapperResult& result) const;
  bool showsMotion(const MapperResult& local) const;
  void remember(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                const MapperResult& result);
  MapperResult follow(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base);
  void beginLocalMap();
  GaussianPose2 predicted(const MapperResult& local) const;
  void compare(const PlanarScan& scan, const MapperResult& local, MapperResult& result);
  bool contradicts(const PlanarScan& scan, const Pose2& map_T_base) const;
  std::optional<MapperResult> returnToMap(const PlanarScan& scan,
                                          const std::optional<Pose2>& odom_T_base,
                                          const MapperResult& result);
  std::optional<MapperResult> searchWhileFollowing(const PlanarScan& scan,
                                                   const std::optional<Pose2>& odom_T_base,
                                                   const MapperResult& result);
  std::int64_t workFor(const PlanarScan& scan) const;
  MapperResult search(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base);
  MapperResult unknownPose(MapperResult result) const;
  std::optional<MapperResult> confirm(const PlanarScan& scan,
                                      const std::optional<Pose2>& odom_T_base, const Pose2& pose);
  void lose(const Pose2& map_T_base);

  MapperConfig local_config_;
  Mapper tracker_;
  GlobalMap global_;
  PlaceFinder finder_;
  std::unique_ptr<Mapper> local_;  ///< while following or lost: measures the motion
  bool lost_ = true;
  Known known_;                          ///< if lost: where it was last seen
  bool motion_known_ = false;            ///< while following: all scans fit to those before them
  std::optional<PlanarScan> last_scan_;  ///< that fitted clearly
  std::optional<Pose2> last_odometry_;   ///< at this scan
  std::optional<double> fit_time_;       ///< of the last scan that did not contradict the pose, s
  std::optional<double> time_;           ///< of the last scan, s
};

}  // namespace kestrel
