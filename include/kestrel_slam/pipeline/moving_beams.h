// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/tracking/continuous_pose.h"
#include "kestrel_slam/tracking/tracker.h"

namespace kestrel {

/// The tracker beside the mapper: it gets the poses of the mapper, and keeps the beams on what
/// moves out of matching and map. Only objects that are shown are kept out: the static grid of the
/// tracker takes back what stands, so that a wall that was wrongly kept out is used again.
class MovingBeams {
 public:
  /// Turns the returns from what moves into beams that only clear the space before it.
  void keepOut(PlanarScan& scan) const;
  /// Adds the complete scan with its pose.
  void add(const PlanarScan& scan, const MapperResult& result,
           const std::optional<Pose2>& odom_T_base);
  /// The map starts anew.
  void reset();

  const Tracker::Result& result() const { return tracker_.result(); }
  /// Pose of the last scan in the frame of the tracks.
  const Pose2& pose() const { return pose_; }

 private:
  Tracker tracker_;
  ContinuousPose continuous_;
  Pose2 pose_;
};

}  // namespace kestrel
