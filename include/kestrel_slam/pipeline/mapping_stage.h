// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "kestrel_slam/graph/localizer.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/pipeline/moving_beams.h"
#include "kestrel_slam/sensor/time_base.h"

namespace kestrel {

/// The mapper and the time base of its scans. Both the mapper node and the pipeline use this class.
/// Not thread-safe.
class MappingStage {
 public:
  /// `keep_out_moving`: see MovingBeams.
  explicit MappingStage(const MapperConfig& config, bool keep_out_moving = false);

  /// From now on the vehicle is only localized in this map, which does not change.
  void localizeIn(Submap map);
  /// The same with a localizer that was made before, which takes some time.
  void localizeWith(std::unique_ptr<Localizer> localizer);
  /// Ends the localization. The map of the mapper is kept.
  void mapAgain(const Pose2& map_T_base);
  /// Whether the mapper has a map, besides the one to localize in.
  bool hasOwnMap() const { return mapper_.map().scans() > 0; }
  /// Null while it maps.
  Localizer* localizer() { return localizer_.get(); }

  /// Matches a planar scan. If the caller has already repaired the time base, the argument `time`
  /// (s) is used. Otherwise the time of the scan is computed from its stamp; each source has its
  /// own time base. A scan of another laser may be older than the newest scan: it is matched at its
  /// own place and the result is the pose at its time. Returns from what moves become beams that
  /// only clear, if they are kept out.
  MapperResult process(PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                       const std::optional<double>& time = std::nullopt);

  /// See Mapper::configure.
  void configure(const MapperConfig& config) { mapper_.configure(config); }
  /// Begins or ends to keep out what moves.
  void keepOutMoving(bool enabled);

  /// Deletes the map. The next scan starts a new map at `map_T_base`. While it localizes, the map
  /// stays, and this is setPose().
  void reset(const Pose2& map_T_base);
  /// Keeps the map and sets the pose of the vehicle.
  void setPose(const Pose2& map_T_base);
  /// Keeps map and pose but resets the motion model. Used after a gap or a jump in time.
  void restartMotion();

  /// See Mapper::takeChangedTiles.
  bool takeChangedTiles(std::size_t max_tiles, std::vector<TileImage>& images) {
    return localizer_ ? localizer_->takeChangedTiles(max_tiles, images)
                      : mapper_.takeChangedTiles(max_tiles, images);
  }

  const Mapper& mapper() const { return localizer_ ? localizer_->mapper() : mapper_; }
  /// Null if what moves is not kept out.
  const MovingBeams* moving() const { return moving_.get(); }

 private:
  /// What the mapper got with a scan, and its pose.
  struct Step {
    double time;
    Pose2 pose;
    std::optional<double> integrated_yaw;
    std::optional<Eigen::Vector2d> integrated_acceleration;
    std::optional<Pose2> predicted, odom_T_base;
  };

  MapperResult match(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base);
  MapperResult processLate(const PlanarScan& scan);
  std::optional<Pose2> poseAt(double time) const;
  void remember(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base, const Pose2& pose);

  TimeBase time_base_;
  Mapper mapper_;
  std::unique_ptr<MovingBeams> moving_;
  std::unique_ptr<Localizer> localizer_;
  std::deque<Step> steps_;  ///< of the last second, ascending times
};

}  // namespace kestrel
