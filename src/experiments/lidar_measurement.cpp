// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/lidar_measurement.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr int kFirstFrame = 5;  ///< the map has grown [Siew 2018, sec. VI-A]
constexpr double kDegree = 180.0 / kPi;

PoseErrors::Vector anglesAndPlace(const Eigen::Isometry3d& pose) {
  const Eigen::Matrix3d& R = pose.linear();
  PoseErrors::Vector result;
  result << std::atan2(R(2, 1), R(2, 2)), -std::asin(std::clamp(R(2, 0), -1.0, 1.0)),
      std::atan2(R(1, 0), R(0, 0)), pose.translation();
  return result;
}

PoseErrors::Vector errorOf(const Eigen::Isometry3d& pose, const Eigen::Isometry3d& truth) {
  PoseErrors::Vector error = anglesAndPlace(pose) - anglesAndPlace(truth);
  for (int i = 0; i < 3; ++i) error(i) = normalizeAngle(error(i));
  return error;
}

/// Compares frame by frame.
class Comparison {
 public:
  explicit Comparison(const LidarMeasurementOptions& options)
      : options_(options),
        all_(options.match_m),
        vehicles_(options.match_m),
        pedestrians_(options.match_m) {}

  void add(const LabeledSweep& sweep, const CloudTracker::Result& result) {
    if (frame_ == 0) start_ = sweep.pose;
    addPose(sweep, result);
    addObjects(sweep, result);
    addPoints(sweep, result);
    ++frame_;
  }

  LidarMeasurement finish() {
    m_.objects = all_.result();
    m_.vehicles = vehicles_.result();
    m_.pedestrians = pedestrians_.result();
    m_.mean_points /= std::max(frame_, 1);
    return m_;
  }
  void noteMemory(std::size_t bytes) { m_.memory = std::max(m_.memory, bytes); }

 private:
  /// The map begins at the true first pose.
  void addPose(const LabeledSweep& sweep, const CloudTracker::Result& result) {
    const Eigen::Isometry3d pose = start_ * result.pose;
    if (frame_ > kFirstFrame) {
      const Eigen::Isometry3d change = last_.inverse() * pose;
      const Eigen::Isometry3d true_change = last_truth_.inverse() * sweep.pose;
      m_.change.add(errorOf(change, true_change));
      m_.pose.add(errorOf(pose, sweep.pose));
      const Eigen::Isometry3d error = true_change.inverse() * change;
      m_.largest_step_m = std::max(m_.largest_step_m, error.translation().norm());
      m_.largest_turn_deg = std::max(m_.largest_turn_deg,
                                     kDegree * std::abs(Eigen::AngleAxisd(error.linear()).angle()));
    }
    last_ = pose;
    last_truth_ = sweep.pose;
  }

  bool isNear(const Eigen::Vector3d& place, const LabeledSweep& sweep) const {
    return (place - sweep.pose.translation()).norm() <= options_.range_m;
  }

  bool counts(const TrueBox& box, const LabeledSweep& sweep) const {
    return box.moving && box.points >= options_.fewest_points && isNear(box.center, sweep);
  }

  void addObjects(const LabeledSweep& sweep, const CloudTracker::Result& result) {
    TrackedFrame frame;
    for (const CloudTrack& track : result.tracks) {
      if (!track.isShown()) continue;
      // Seen from above, in the true world: errors of the pose are counted elsewhere.
      const Eigen::Vector3d at(track.plane.position.x(), track.plane.position.y(), track.z);
      Eigen::Vector3d place = sweep.pose * (result.pose.inverse() * at);
      if (!isNear(place, sweep)) continue;
      place.z() = 0.0;
      frame.tracks.push_back({track.plane.id, place, true});
    }
    for (const TrueBox& box : sweep.boxes) {
      frame.truth.push_back({box.id, {box.center.x(), box.center.y(), 0.0}, counts(box, sweep)});
    }
    all_.add(frame);
    addKind(frame, sweep, true, vehicles_);
    addKind(frame, sweep, false, pedestrians_);
  }

  /// Only one kind of objects counts. Tracks that belong to none are counted with all objects.
  void addKind(TrackedFrame frame, const LabeledSweep& sweep, bool vehicles,
               ClearMotCounter& counter) const {
    for (std::size_t i = 0; i < frame.truth.size(); ++i) {
      if ((sweep.boxes[i].kind == ActorKind::kVehicle) != vehicles) frame.truth[i].counts = false;
    }
    counter.add(frame);
  }

  void addPoints(const LabeledSweep& sweep, const CloudTracker::Result& result) {
    m_.mean_points += static_cast<double>(sweep.cloud.points.size());
    if (!result.used || frame_ < kFirstFrame) return;
    std::map<long, bool> moves;
    for (const TrueBox& box : sweep.boxes) moves[box.id] = box.moving;
    for (std::size_t i = 0; i < sweep.labels.size(); ++i) {
      const PointCloud::Point& p = sweep.cloud.points[i];
      if (std::hypot(p.x, p.y) > static_cast<float>(options_.range_m)) continue;
      const bool is_moving = sweep.labels[i] != 0 && moves[sweep.labels[i]];
      if (sweep.labels[i] != 0 && !is_moving) continue;
      if (is_moving && result.moving[i]) ++m_.points.right;
      if (is_moving && !result.moving[i]) ++m_.points.missed;
      if (!is_moving && result.moving[i]) ++m_.points.wrong;
    }
  }

  const LidarMeasurementOptions& options_;
  ClearMotCounter all_, vehicles_, pedestrians_;
  LidarMeasurement m_;
  Eigen::Isometry3d start_, last_, last_truth_;
  int frame_ = 0;
};

}  // namespace

void PoseErrors::add(const Vector& error) {
  ++count;
  max = max.cwiseMax(error.cwiseAbs());
  sum += error;
  square_sum += error.cwiseAbs2();
}

PoseErrors::Vector PoseErrors::mean() const {
  return sum / static_cast<double>(std::max<std::size_t>(count, 1));
}

PoseErrors::Vector PoseErrors::sigma() const {
  const Vector square = square_sum / static_cast<double>(std::max<std::size_t>(count, 1));
  return (square - mean().cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
}

double PointCounts::iou() const {
  const std::size_t all = right + missed + wrong;
  return all > 0 ? static_cast<double>(right) / static_cast<double>(all) : 1.0;
}

LidarMeasurement measureScene(const TrafficScene& scene, const CloudTrackerConfig& config,
                              const LidarMeasurementOptions& options) {
  const TrafficSimulator simulator(scene);
  CloudTracker tracker(config);
  Comparison comparison(options);
  for (int frame = 0; frame < scene.frames; ++frame) {
    const LabeledSweep sweep = simulator.sweep(frame);
    const LidarSweep input{
        sweep.cloud, options.use_unanswered ? sweep.unanswered : std::vector<Eigen::Vector3f>()};
    const CloudTracker::Result& result = tracker.process(input);
    comparison.add(sweep, result);
    comparison.noteMemory(tracker.memoryBytes());
    if (options.observer) options.observer(sweep, result);
  }
  return comparison.finish();
}

}  // namespace kestrel
