// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "kestrel_slam/tracking/motion_grid.h"
#include "kestrel_slam/tracking/object_box.h"
#include "kestrel_slam/tracking/tracker_config.h"

namespace kestrel {

/// Class of an object by the longer side of its box.
enum class SizeClass { kSmall, kPerson, kMedium, kVehicle };
const char* toString(SizeClass size);
/// The class of a size, m.
SizeClass sizeClassOf(double size);

enum class TrackState {
  kTentative,  ///< new, perhaps clutter
  kConfirmed,
  kCoasting  ///< without an observation in this scan: hidden or missed
};
const char* toString(TrackState state);

/// A track is shown without observations for this time, s. It lives longer, so that an object that
/// was hidden gets its identity back.
constexpr double kShownUnseen = 0.5;

/// An object with one identity, in the frame of the poses that the tracker gets.
struct Track {
  long id = 0;
  TrackState state = TrackState::kTentative;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();    ///< m
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();    ///< m/s
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of position and velocity
  double turn_rate = 0.0;                                ///< rad/s
  OrientedBox box;                     ///< of the visible points, the last that was seen
  SizeClass size = SizeClass::kSmall;  ///< from the largest box that was seen
  double age_s = 0.0;                  ///< since the first observation
  double unseen_s = 0.0;               ///< since the last observation
  /// It has moved away from where it was first seen. Stays true when it stops. Only such tracks
  /// are of interest to users.
  bool moved = false;
  double standing = 0.0;  ///< probability that it stands now

  bool isShown() const {
    return moved && state != TrackState::kTentative && unseen_s <= kShownUnseen;
  }
};

/// Finds and follows what moves in the scans of a 2D laser [Siew 2018]: static and dynamic grid,
/// moving points, clusters, PHD filter, tracks. Deterministic; uses no clock; bounded work.
class Tracker {
 public:
  explicit Tracker(const TrackerConfig& config = TrackerConfig());
  ~Tracker();
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;

  struct Result {
    std::vector<Track> tracks;       ///< all, also those that do not move, by rising id
    std::vector<CellMotion> motion;  ///< of each ray of the scan
    std::vector<bool> is_moving;     ///< of each ray: its return is from an object that is shown
    bool saturated = false;          ///< a bound on the work was reached; something may be missing
    bool used = false;               ///< false: time or pose cannot be used, nothing has changed
  };

  /// Adds a scan. `odom_T_base`: pose at the time of the scan, in a frame without jumps. Scans that
  /// are not newer than the last one are ignored. Valid until the next call.
  const Result& process(const PlanarScan& scan, const Pose2& odom_T_base);

  /// The last result.
  const Result& result() const;
  /// The rays of a scan that is not processed yet which end where a shown object should be then.
  std::vector<bool> expectMoving(const PlanarScan& scan, const Pose2& odom_T_base) const;

  const MotionGrid<2>& grid() const;
  /// Forgets everything; track ids go on.
  void reset();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
