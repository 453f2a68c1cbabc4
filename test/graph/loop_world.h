// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/graph/submap_graph.h"
#include "room.h"

namespace kestrel::loop_world {

/// A box, as a niche or a pillar.
inline void addBox(std::vector<room::Segment>& walls, double x, double y, double w, double h) {
  for (const room::Segment& side :
       {room::Segment{x, y, x + w, y}, room::Segment{x + w, y, x + w, y + h},
        room::Segment{x + w, y + h, x, y + h}, room::Segment{x, y + h, x, y}})
    walls.push_back(side);
}

/// A ring of corridors: outer walls at ±12 m, inner walls at ±9 m, and boxes at irregular places.
inline std::vector<room::Segment> ring() {
  std::vector<room::Segment> walls;
  addBox(walls, -12, -12, 24, 24);
  addBox(walls, -9, -9, 18, 18);
  for (const double at : {-7.1, -3.9, 0.6, 2.3, 6.8}) {
    addBox(walls, at, -12, 0.4, 0.7);
    addBox(walls, -at + 0.9, 11.5, 0.7, 0.5);
    addBox(walls, 11.4, at * 1.1, 0.6, 0.3);
    addBox(walls, -12, at * 0.9 - 0.5, 0.5, 0.9);
  }
  return walls;
}

/// Poses on a square path through the ring, from its lower left corner: every 0.25 m, and every 10°
/// in the corners.
inline std::vector<Pose2> laps(double count) {
  constexpr double kSide = 21.0, kStep = 0.25;
  constexpr int kTurns = 9;
  const Pose2 corners[] = {
      {-10.5, -10.5, 0.0}, {10.5, -10.5, kPi / 2}, {10.5, 10.5, kPi}, {-10.5, 10.5, -kPi / 2}};
  std::vector<Pose2> poses;
  for (int side = 0; side < 4.0 * count; ++side) {
    const double length = kSide * std::min(1.0, 4.0 * count - side);
    for (int i = 1; side > 0 && i < kTurns; ++i)
      poses.push_back(corners[side % 4] * Pose2(0.0, 0.0, kPi / 2 * i / kTurns - kPi / 2));
    for (double along = 0.0; along < length; along += kStep)
      poses.push_back(corners[side % 4] * Pose2(along, 0.0, 0.0));
  }
  return poses;
}

/// Feeds a graph as the mapper does, with poses that drift.
class Drive {
 public:
  /// `begin`: the first pose in the local frame of the mapper.
  Drive(std::vector<room::Segment> walls, double yaw_drift, const Pose2& begin = Pose2())
      : walls_(std::move(walls)), yaw_drift_(yaw_drift), local_(begin) {}

  void add(const Pose2& truth, SubmapGraph& graph) {
    if (!truths_.empty())
      local_ = local_ * truths_.back().between(truth) * Pose2(0.0, 0.0, yaw_drift_);
    truths_.push_back(truth);
    PlanarScan scan = room::scanFrom(truth, walls_, beams, max_range_m);
    scan.height = height;
    scan.stamp = scan.time = 0.1 * static_cast<double>(truths_.size());
    MapperResult result;
    if (with_odometry) result.odom_T_base = truth;
    result.inserted = true;
    result.pose = local_;
    result.submap = static_cast<std::uint32_t>(truths_.size() / 60);
    constexpr double kSigmaM = 0.005, kSigmaRad = 0.002;
    result.keyframe_covariance.diagonal() << kSigmaM * kSigmaM, kSigmaM * kSigmaM,
        kSigmaRad * kSigmaRad;
    result.lasting_covariance = result.keyframe_covariance;
    result.keyframe_covariance += 2.0 * match;
    result.uncertain = {
        local_, truths_.size() == 1 ? first : Eigen::Matrix3d(Eigen::Matrix3d::Zero()), match};
    graph.add(scan, result);
  }

  /// What is seen from now on, as at another height.
  void see(std::vector<room::Segment> walls, float height_m) {
    walls_ = std::move(walls);
    height.base_m = height_m;
  }

  int beams = 180;
  double max_range_m = 12.0;
  ScanHeight height;
  /// Whether the wheels measure the true motion.
  bool with_odometry = false;
  /// What the mapper says of the error of each match, and of the map at the first keyframe.
  Eigen::Matrix3d match = Eigen::Matrix3d::Zero(), first = Eigen::Matrix3d::Zero();

  /// Error of the last corrected pose relative to the first, m.
  double lastError(const SubmapGraph& graph) const {
    const std::size_t last = truths_.size() - 1;
    const Pose2 estimated = graph.poseOf(0).between(graph.poseOf(last));
    return truths_[0].between(truths_[last]).between(estimated).distance();
  }

  /// The largest error of an accepted loop, m.
  double worstLoop(const SubmapGraph& graph) const {
    double worst = 0.0;
    for (const Loop& loop : graph.loops()) {
      if (loop.state != LoopState::kAccepted) continue;
      const Pose2 truth = truths_[loop.anchor].between(truths_[loop.query]);
      worst = std::max(worst, truth.between(loop.anchor_T_query.mean).distance());
    }
    return worst;
  }

 private:
  std::vector<room::Segment> walls_;
  double yaw_drift_;  ///< rad for each keyframe
  std::vector<Pose2> truths_;
  Pose2 local_;
};

inline std::size_t acceptedLoops(const SubmapGraph& graph) {
  std::size_t count = 0;
  for (const Loop& loop : graph.loops()) count += loop.state == LoopState::kAccepted ? 1 : 0;
  return count;
}

}  // namespace kestrel::loop_world
