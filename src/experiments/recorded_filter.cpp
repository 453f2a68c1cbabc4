// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/recorded_filter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/offline/offline_run.h"

namespace kestrel {
namespace {

constexpr double kHalfDifference_s = 0.1;  // averages the noise of the motion capture

/// Computes the reference velocity around `stamp`. Returns false if the reference has a gap there.
bool velocityAt(const Trajectory& reference, double stamp, Eigen::Vector2d& velocity) {
  const auto is_before = [](const StampedPose& pose, double t) { return pose.stamp < t; };
  const auto at = [&](double t) {
    return std::lower_bound(reference.begin(), reference.end(), t, is_before);
  };
  const auto from = at(stamp - kHalfDifference_s), to = at(stamp + kHalfDifference_s);
  if (to == reference.end() || from == reference.begin() || from == to) return false;
  const double seconds = to->stamp - from->stamp;
  if (seconds > kMaxReferenceGap) return false;
  velocity = (to->pose.translation() - from->pose.translation()) / seconds;
  return true;
}

}  // namespace

MovingErrors compareWithReference(const std::vector<MovingPose>& poses,
                                  const Trajectory& reference) {
  Trajectory trajectory;
  for (const MovingPose& pose : poses) trajectory.push_back(pose.pose);
  const ReferenceEvaluation evaluation = evaluateReference(trajectory, reference);
  const Eigen::Rotation2Dd turn(evaluation.reference_T_map.yaw);
  MovingErrors errors;
  errors.position_rmse_m = evaluation.ate_statistics.translation_m.rmse;
  double squares = 0.0;
  for (const MovingPose& pose : poses) {
    Eigen::Vector2d truth;
    if (!velocityAt(reference, pose.pose.stamp, truth)) continue;
    squares += (turn * pose.velocity - truth).squaredNorm();
    ++errors.count;
  }
  errors.velocity_rmse = std::sqrt(squares / std::max(1.0, static_cast<double>(errors.count)));
  return errors;
}

RecordedFilterRun runFiltered(Recording& recording, const SlamConfig& config,
                              const PoseFilterConfig& filter, const CouplingOptions& coupling,
                              const std::optional<Eigen::Isometry3d>& base_T_laser) {
  if (recording.imu().samples.empty()) {
    throw std::runtime_error("the recording has no IMU, which the pose filter needs");
  }
  RecordedFilterRun result;
  RunOptions options;
  options.use_filter = true;
  options.filter = filter;
  options.coupling = coupling;
  options.base_T_laser = base_T_laser;
  options.filter_observer = [&](const FilterOutput& output) {
    result.filter.push_back(
        {{output.stamp, toPose2(output.map_T_base)}, output.velocity.head<2>()});
  };
  options.observer = [&](const PlanarScan& scan, const MapperResult& found) {
    if (found.state == MatchState::kLost) return;
    const Eigen::Vector2d velocity = Eigen::Rotation2Dd(found.pose.yaw) * found.velocity;
    result.mapper.push_back({{scan.stamp, found.pose}, velocity});
  };
  result.status = *runOffline(recording, config, options).filter;
  return result;
}

}  // namespace kestrel
