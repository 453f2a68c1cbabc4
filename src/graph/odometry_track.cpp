// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/odometry_track.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kestrel {
namespace {

/// Scans before and after a keyframe that may have its pose.
constexpr std::size_t kAround = 2;
/// Delays in scans, most likely first. Fractions would take the mean of two poses, which looks
/// better than it is.
constexpr int kDelays[] = {0, 1, -1, 2, -2};
/// Factor of the information of a match that may be wrong and contradicts the odometry.
constexpr double kWeak = 1e-4;
constexpr double kLeastLengthM = 0.01;

Eigen::Matrix3d informationOf(const Eigen::Vector3d& variances) {
  return variances.cwiseInverse().asDiagonal();
}

}  // namespace

void OdometryTrack::add(const std::optional<Pose2>& odom_T_base, bool is_reversed) {
  const std::optional<Pose2> measured = signed_.next(odom_T_base, is_reversed);
  if (!measured) return recent_.clear();
  const std::size_t open = keyframes_.size() - closed_;
  for (std::size_t i = keyframes_.size() - std::min(open, kAround); i < keyframes_.size(); ++i) {
    TrackedKeyframe& keyframe = keyframes_[i];
    if (keyframe.odometry.size() <= keyframe.own + kAround) keyframe.odometry.push_back(*measured);
  }
  if (recent_.size() > kAround) recent_.erase(recent_.begin());
  recent_.push_back(*measured);
}

void OdometryTrack::addKeyframe(std::size_t keyframe, const Pose2& local_T_base) {
  if (recent_.empty()) return;
  keyframes_.push_back({keyframe, local_T_base, recent_, recent_.size() - 1});
}

std::vector<OdometryPoint> OdometryTrack::pointsAt(int delay_scans) const {
  std::vector<OdometryPoint> result;
  for (const TrackedKeyframe& keyframe : keyframes_) {
    const auto number = static_cast<std::ptrdiff_t>(keyframe.own) + delay_scans;
    if (number < 0 || number >= static_cast<std::ptrdiff_t>(keyframe.odometry.size())) continue;
    result.push_back({keyframe.number, keyframe.local_T_base,
                      keyframe.odometry[static_cast<std::size_t>(number)]});
  }
  return result;
}

void OdometryTrack::learn(const OdometryChain& chain) {
  double least = std::numeric_limits<double>::infinity();
  for (const int delay : kDelays) {
    const double difference = stepDifference(pointsAt(delay), chain);
    if (difference >= least) continue;
    least = difference;
    delay_scans_ = delay;
  }
  worth_ = worthOf(pointsAt(delay_scans_), chain);
}

/// The edge that leads from one vertex of the odometry to the next one.
PoseEdge OdometryTrack::edgeBetween(const OdometryPoint& a, const OdometryPoint& b,
                                    std::size_t to) const {
  const Pose2 motion = a.measured.between(b.measured);
  const double length = std::max(kLeastLengthM, lengthOf(motion));
  const double yaw = worth_.yaw_growth * length;
  const double position =
      worth_.position_growth * length + yaw * motion.translation().squaredNorm() / 3.0;
  return {to - 1, to, motion, informationOf({position, position, yaw}), EdgeKind::kLoop};
}

OdometrySelection OdometryTrack::addTo(PoseGraph& graph, const OdometryChain& chain,
                                       const std::vector<bool>& doubtful) const {
  if (worth_.position_m2 <= 0.0) return {};
  std::vector<OdometryPoint> points = pointsAt(delay_scans_);
  correct(worth_, points);
  OdometrySelection result = selectOdometry(points, worth_, chain, doubtful, delay_scans_ != 0);
  const Eigen::Matrix3d pose_information =
      informationOf({worth_.position_m2, worth_.position_m2, worth_.yaw_rad2});
  std::vector<bool> weak(graph.vertices.size(), false);
  for (std::size_t i = 0; i < result.points.size(); ++i) {
    const OdometryPoint& point = result.points[i];
    const std::size_t vertex = graph.vertices.size();
    graph.vertices.push_back({graph.vertices[point.keyframe].pose, false});
    graph.edges.push_back({vertex, point.keyframe, Pose2(), pose_information, EdgeKind::kLoop});
    if (i == 0) continue;
    const OdometryPoint& before = result.points[i - 1];
    if (chain.partOf(before.keyframe) != chain.partOf(point.keyframe)) continue;
    graph.edges.push_back(edgeBetween(before, point, vertex));
    if (agree(before, point, worth_, chain)) continue;
    for (std::size_t k = before.keyframe + 1; k <= point.keyframe; ++k)
      weak[k] = result.refuted[k] || result.refuted[k - 1];
  }
  for (PoseEdge& edge : graph.edges)
    if (edge.kind == EdgeKind::kOdometry && weak[edge.to]) edge.information *= kWeak;
  return result;
}

void OdometryTrack::place(const OdometrySelection& selection, const PoseGraph& graph) {
  placed_.clear();
  single_ = selection.single;
  const std::size_t first = graph.vertices.size() - selection.points.size();
  for (std::size_t i = 0; i < selection.points.size(); ++i)
    placed_.push_back({selection.points[i].keyframe, graph.vertices[first + i].pose});
}

std::size_t OdometryTrack::memoryBytes() const {
  std::size_t bytes =
      keyframes_.capacity() * sizeof(TrackedKeyframe) + placed_.capacity() * sizeof(PlacedOdometry);
  for (const TrackedKeyframe& keyframe : keyframes_)
    bytes += keyframe.odometry.capacity() * sizeof(Pose2);
  return bytes;
}

}  // namespace kestrel
