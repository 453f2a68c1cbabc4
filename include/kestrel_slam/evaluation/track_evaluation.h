// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/evaluation/track_file.h"
#include "kestrel_slam/evaluation/tracking_metrics.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/recording/trajectory.h"
#include "kestrel_slam/recording/true_objects.h"

namespace kestrel {

struct TrackEvaluationOptions {
  double max_distance_m = 0.75;  ///< of a match; also the cutoff of OSPA and GOSPA
  Pose2 base_T_sensor;           ///< frame of the true positions
  /// True positions belong to the scan whose stamp is at most this far, s. Between two true
  /// positions of an object that are at most `max_gap_s` apart its position is interpolated.
  double stamp_tolerance_s = 0.07;
  double max_gap_s = 0.0;
  /// Between two true positions of an object that are at most this far apart, s, the object is
  /// there, but was not marked: a track on it is neither right nor wrong.
  double unmarked_s = 1.0;
  /// Only tracks in this range of bearings of the sensor are compared, rad: people who annotate
  /// scans often mark only a part of the view.
  double min_bearing = -kPi, max_bearing = kPi;
  /// An object moves if it was this far from here within the last seconds.
  double moved_m = 0.5, moved_within_s = 5.0;
};

/// Why true objects that move have no shown track within the distance of a match: what the nearest
/// track that is not shown lacks.
struct LossCounts {
  std::size_t no_track = 0;    ///< nothing was observed there, or the filter did not follow it
  std::size_t tentative = 0;   ///< the track is not confirmed
  std::size_t not_moving = 0;  ///< the track is not known to move
  std::size_t unseen = 0;      ///< the track was not observed for too long
};

/// Tracks that are shown, compared with true objects, scan by scan from the first to the last true
/// position.
struct TrackEvaluation {
  ClearMot all;  ///< over all true objects
  ClearMot
      moving;  ///< only those that move count; tracks of the others are neither right nor wrong
  LossCounts losses;               ///< of `moving`
  double ospa = 0.0, gospa = 0.0;  ///< means over the scans, m
  double position_rmse = 0.0;      ///< of the matches, m
  double speed_rmse = 0.0;         ///< of the velocity vector, of matches with a true velocity, m/s
  std::size_t speeds = 0;
  double identity_share = 0.0;  ///< mean share of its time that an object had one identity
};

/// Throws std::runtime_error if no scan has a true position.
TrackEvaluation evaluateTracks(const Trajectory& trajectory, const std::vector<TrackRow>& tracks,
                               const std::vector<TrueObject>& truth,
                               const TrackEvaluationOptions& options);

}  // namespace kestrel
