// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/flight_measurement.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/recording/simulated_recording.h"
#include "kestrel_slam/sensor/attitude_buffer.h"

namespace kestrel {
namespace {

double distanceToBox(const Box& box, const Eigen::Vector2d& point) {
  const Eigen::Vector2d local = Eigen::Rotation2Dd(-box.yaw) * (point - box.center.head<2>());
  const Eigen::Vector2d beyond = local.cwiseAbs() - 0.5 * box.size.head<2>();
  const double outside = beyond.cwiseMax(0.0).norm();
  return outside > 0.0 ? outside : -beyond.maxCoeff();
}

void countCells(const World::Parts& parts, FlightMeasurement& result) {
  const MapSnapshot& map = result.run.map;
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      if (map.at(column, row) != MapSnapshot::kOccupied) continue;
      ++result.occupied_cells;
      const Eigen::Vector2d in_map(map.origin_x + (column + 0.5) * map.resolution_m,
                                   map.origin_y + (row + 0.5) * map.resolution_m);
      const Eigen::Vector2d in_world = result.error.reference_T_map * in_map;
      if (distanceToUprightSurface(parts, in_world) > kFalseDistance) ++result.false_cells;
    }
  }
}

/// Combines estimated and true poses. Both have the same order; every scan has a true pose.
std::vector<EvaluatedPose> evaluatedPoses(const OfflineRun& run, const Trajectory& truth) {
  std::vector<EvaluatedPose> result;
  std::size_t k = 0;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    while (k < truth.size() && truth[k].stamp < run.trajectory[i].stamp) ++k;
    if (k == truth.size()) break;
    result.push_back({truth[k].stamp, run.scans[i].uncertain, truth[k].pose});
  }
  if (result.empty()) return result;
  const Pose2 map_T_world = result.front().estimate.pose * result.front().truth.inverse();
  for (EvaluatedPose& pose : result) pose.truth = map_T_world * pose.truth;
  return result;
}

}  // namespace

double distanceToUprightSurface(const World::Parts& parts, const Eigen::Vector2d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Box& box : parts.boxes) nearest = std::min(nearest, distanceToBox(box, point));
  for (const Cylinder& cylinder : parts.cylinders) {
    nearest = std::min(nearest, std::abs((point - cylinder.center).norm() - cylinder.radius));
  }
  return nearest;
}

FlightMeasurement measureFlight(const FlightTrial& trial) {
  SimulatedRecording recording(trial.place, trial.vehicle, trial.seed);
  FlightMeasurement result;
  result.run = runOffline(recording, trial.config, trial.options);
  result.error = evaluateReference(result.run.trajectory, recording.truth());
  result.consistency = consistencyOf(evaluatedPoses(result.run, recording.truth()));
  for (const ScanRecord& scan : result.run.scans) {
    if (scan.state == MatchState::kLost) ++result.lost;
    if (scan.degenerate) ++result.degenerate;
  }
  for (const TrueState& state : recording.trueStates()) {
    const double tilt = tiltOf(Eigen::Quaterniond(state.world_T_base.linear()));
    result.max_tilt_deg = std::max(result.max_tilt_deg, radToDeg(tilt));
    result.max_yaw_rate_rad_s =
        std::max(result.max_yaw_rate_rad_s, std::abs(state.angular_velocity.z()));
  }
  countCells(trial.place.parts, result);
  return result;
}

}  // namespace kestrel
