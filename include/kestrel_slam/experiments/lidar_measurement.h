// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>

#include "kestrel_slam/evaluation/tracking_metrics.h"
#include "kestrel_slam/lidar/cloud_tracker.h"
#include "kestrel_slam/simulation/traffic.h"

namespace kestrel {

/// Errors of roll, pitch, yaw (rad) and x, y, z (m).
struct PoseErrors {
  using Vector = Eigen::Matrix<double, 6, 1>;
  std::size_t count = 0;
  Vector max = Vector::Zero();  ///< of the absolute value
  Vector sum = Vector::Zero(), square_sum = Vector::Zero();

  void add(const Vector& error);
  Vector mean() const;
  Vector sigma() const;
};

/// Points that were marked as moving, compared with the truth.
struct PointCounts {
  std::size_t right = 0, missed = 0, wrong = 0;

  double iou() const;  ///< intersection over union of the moving points
};

/// Results of a simulated scene.
struct LidarMeasurement {
  PoseErrors change, pose;  ///< as in tables 5 and 6 of [Siew 2018], from frame 5 on
  double largest_turn_deg = 0.0, largest_step_m = 0.0;  ///< error of a change of pose, as a whole
  ClearMot objects, vehicles, pedestrians;
  PointCounts points;
  double mean_points = 0.0;  ///< of a cloud
  std::size_t memory = 0;    ///< largest of both maps, bytes
};

struct LidarMeasurementOptions {
  double range_m = 50.0;           ///< objects and points beyond do not count
  double match_m = 2.0;            ///< of a track and an object, seen from above
  std::size_t fewest_points = 10;  ///< an object with fewer returns does not count
  bool use_unanswered = true;      ///< the sensor tells the directions without return
  /// Called after each frame.
  std::function<void(const LabeledSweep&, const CloudTracker::Result&)> observer;
};

/// Runs the tracker on the frames of a scene and compares it with the truth: objects that were more
/// than 0.5 m elsewhere within the last 5 s have to be tracked, and their points to be marked;
/// others are neither right nor wrong.
LidarMeasurement measureScene(const TrafficScene& scene, const CloudTrackerConfig& config,
                              const LidarMeasurementOptions& options = LidarMeasurementOptions());

}  // namespace kestrel
