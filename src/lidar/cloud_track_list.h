// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "cloud_objects.h"
#include "kestrel_slam/lidar/cloud_tracker.h"
#include "kestrel_slam/tracking/phd_filter.h"
#include "lidar_view.h"

namespace kestrel {

/// The tracks that belong to the labels of the PHD filter. The state of the filter is position,
/// velocity and turn rate.
class CloudTrackList {
 public:
  explicit CloudTrackList(const CloudTrackerConfig& config) : config_(config) {}

  /// Moves all tracks on with their velocities.
  void predict(double seconds);
  /// Takes over the targets of the last update, and makes the filter forget deleted tracks.
  void update(PhdFilter<7, 3>& filter, const std::vector<CloudObject>& objects,
              const std::vector<MovingVoxel>& voxels, const LidarView& view,
              const MotionGrid<3>& grid);

  /// All tracks by rising id.
  std::vector<CloudTrack> tracks() const;
  /// For each observation of the last update, the index of its track in tracks(); -1: none.
  const std::vector<int>& trackOf() const { return track_of_; }

  /// True if the point lies in the box of an object that has moved, and has come here after the
  /// object was first seen: so it belongs to the object, also if this stands now.
  bool claims(const Eigen::Vector3d& point, const MotionGrid<3>& grid) const;
  /// Velocity of the track at the point; zero if there is none.
  Eigen::Vector3d velocityAt(const Eigen::Vector3d& point) const;
  /// What is known of the track at the point.
  std::optional<KnownShape> shapeAt(const Eigen::Vector2d& point) const;
  /// Width (seen from above) and height of the track at the point; those of a person if there is
  /// none, m.
  Eigen::Vector2d sizeAt(const Eigen::Vector2d& point) const;

  long nextId() const { return next_id_; }
  void continueFrom(long id) { next_id_ = id; }

 private:
  struct Entry {
    CloudTrack track;
    TargetLabel label = 0;
    Eigen::Vector2d first = Eigen::Vector2d::Zero();     ///< where it was seen first
    double way = 0.0;                                    ///< largest distance from there, m
    double first_time = 0.0;                             ///< of the grid, s
    Eigen::Vector2d moved_at = Eigen::Vector2d::Zero();  ///< where its motion was seen
    double standing_s = 0.0;                             ///< since then: time in which it stood
    std::vector<Eigen::Vector3f> first_points;           ///< where it was then
    double length = 0.0, width = 0.0;                    ///< largest extents that were seen, m
    double seen_s = 0.0;                                 ///< time with observations
    double hidden_s = 0.0;
    double inside_s = 0.0;  ///< without observations, in the box of another object
    int observation = -1;   ///< of the last update
  };

  const Entry* nearestAt(const Eigen::Vector2d& point, bool whole) const;
  /// The track of which this may be a visible part.
  const Entry* at(const Eigen::Vector2d& point) const { return nearestAt(point, false); }
  Entry& entryOf(const LabeledTarget<7>& target, const CloudObject& object,
                 const std::vector<MovingVoxel>& voxels, const MotionGrid<3>& grid);
  static void startAt(Entry& entry, const CloudObject& object,
                      const std::vector<MovingVoxel>& voxels, const MotionGrid<3>& grid);
  void see(Entry& entry, const LabeledTarget<7>& target, const CloudObject& object,
           const std::vector<MovingVoxel>& voxels, const MotionGrid<3>& grid) const;
  void learnShape(Entry& entry, const CloudObject& object) const;
  static bool isWhereItWasFree(const CloudObject& object, const std::vector<MovingVoxel>& voxels);
  bool hasMoved(const Entry& entry, const CloudObject& object,
                const std::vector<MovingVoxel>& voxels, const MotionGrid<3>& grid) const;
  void miss(Entry& entry, const PhdFilter<7, 3>& filter, const LidarView& view) const;
  bool isInOther(const Entry& entry) const;
  bool isOver(const Entry& entry) const;
  void removeOver(PhdFilter<7, 3>& filter);

  CloudTrackerConfig config_;
  std::vector<Entry> entries_;
  std::vector<int> track_of_;
  double seconds_ = 0.0;  ///< of the last prediction
  long next_id_ = 1;
};

}  // namespace kestrel
