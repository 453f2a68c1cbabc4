// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/recorded_filter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kestrel_slam/evaluation/evaluation.h"

namespace kestrel_slam {
namespace {

constexpr double kHalfDifference_s = 0.1;  // motion capture jitters from frame to frame

/// The reference's velocity around `stamp`; false where it has a gap.
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

/// Everything that has come until `time`, the readings of the range finder and the IMU.
class Feeder {
 public:
  Feeder(const Recording& recording, FilteredMapping& mapping)
      : imu_(recording.imu()), heights_(recording.heights()), mapping_(mapping) {}

  void feedUntil(double time) {
    for (; next_ < imu_.samples.size() && imu_.samples[next_].stamp <= time; ++next_) {
      const double stamp = imu_.samples[next_].stamp;
      for (; height_ < heights_.size() && heights_[height_].stamp <= stamp; ++height_) {
        mapping_.addRange(heights_[height_]);
      }
      mapping_.addImu(imu_.samples[next_], imu_.base_T_imu, stamp);
    }
  }

 private:
  const RecordedImu& imu_;
  const std::vector<HeightSample>& heights_;
  FilteredMapping& mapping_;
  std::size_t next_ = 0, height_ = 0;
};

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
  RecordedFilterRun run;
  FilteredMapping mapping(config, filter, coupling);
  mapping.on_output = [&](const FilterOutput& output) {
    const Pose2 pose = Pose2(output.map_T_base.translation().x(),
                             output.map_T_base.translation().y(), output.yaw());
    run.filter.push_back({{output.stamp, pose}, output.velocity.head<2>()});
  };
  mapping.on_scan = [&](const PlanarScan& scan, const MapperResult& result) {
    if (result.state == MatchState::kLost) return;
    const Eigen::Vector2d velocity = Eigen::Rotation2Dd(result.pose.yaw) * result.velocity;
    run.mapper.push_back({{scan.stamp, result.pose}, velocity});
  };
  Feeder feeder(recording, mapping);
  RecordedScan scan;
  while (recording.next(scan)) {
    feeder.feedUntil(sweepTimes(scan.scan).last);
    mapping.addScan(scan.scan, base_T_laser.value_or(scan.base_T_laser));
  }
  feeder.feedUntil(recording.imu().samples.back().stamp);
  run.status = mapping.filter().status(recording.imu().samples.back().stamp);
  return run;
}

}  // namespace kestrel_slam
