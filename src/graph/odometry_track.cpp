// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/odometry_track.h"

#include <Eigen/LU>
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
/// Odometry and matches agree below this chi2: 99 % of three degrees of freedom.
constexpr double kMostChi2 = 11.345;
/// So many poses in a row may be wrong.
constexpr std::size_t kMostWrong = 6;
/// Factor of the information of a match that may be wrong and contradicts the odometry.
constexpr double kWeak = 1e-4;
constexpr double kLeastLengthM = 0.01;

Eigen::Matrix3d informationOf(const Eigen::Vector3d& variances) {
  return variances.cwiseInverse().asDiagonal();
}

}  // namespace

void OdometryTrack::add(const std::optional<Pose2>& odom_T_base) {
  if (!odom_T_base) return recent_.clear();
  const std::size_t open = keyframes_.size() - closed_;
  for (std::size_t i = keyframes_.size() - std::min(open, kAround); i < keyframes_.size(); ++i) {
    TrackedKeyframe& keyframe = keyframes_[i];
    if (keyframe.odometry.size() <= keyframe.own + kAround)
      keyframe.odometry.push_back(*odom_T_base);
  }
  if (recent_.size() > kAround) recent_.erase(recent_.begin());
  recent_.push_back(*odom_T_base);
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

/// Variances of the error of the odometry from `a` to `b`, with that of both poses.
Eigen::Vector3d OdometryTrack::varianceBetween(const OdometryPoint& a,
                                               const OdometryPoint& b) const {
  const Pose2 motion = a.measured.between(b.measured);
  const double length = lengthOf(motion);
  const double yaw = 2.0 * worth_.yaw_rad2 + worth_.yaw_growth * length;
  const double position = 2.0 * worth_.position_m2 + worth_.position_growth * length +
                          yaw * motion.translation().squaredNorm();
  return {position, position, yaw};
}

/// Whether the odometry from `a` to `b` agrees with the matches.
bool OdometryTrack::agree(const OdometryPoint& a, const OdometryPoint& b,
                          const OdometryChain& chain, bool only_yaw) const {
  const Pose2 error = a.measured.between(b.measured).between(a.matched.between(b.matched));
  const Eigen::Matrix3d to_b = chain.pose(b.keyframe).inverse().adjoint();
  const Eigen::Matrix3d expected =
      Eigen::Matrix3d(varianceBetween(a, b).asDiagonal()) +
      to_b * chain.noiseBetween(a.keyframe, b.keyframe) * to_b.transpose();
  if (only_yaw) return error.yaw * error.yaw <= kMostChi2 * expected(2, 2);
  const Eigen::Vector3d e(error.x, error.y, error.yaw);
  return e.dot(expected.inverse() * e) <= kMostChi2;
}

/// The first point from `i` on that agrees with `last`, or else agrees in yaw: where a scan fits at
/// several places, its yaw is still right. `i` if none of the next ones does.
std::size_t OdometryTrack::nextUsable(const std::vector<OdometryPoint>& points,
                                      const OdometryPoint& last, std::size_t i,
                                      const OdometryChain& chain) const {
  const std::size_t end = std::min(points.size(), i + kMostWrong);
  for (const bool only_yaw : {false, true}) {
    for (std::size_t next = i; next < end; ++next) {
      if (chain.partOf(last.keyframe) != chain.partOf(points[next].keyframe)) break;
      if (agree(last, points[next], chain, only_yaw)) return next;
    }
  }
  return i;
}

/// Without poses that contradict those before and after them, which agree with each other: they
/// were measured at another time.
std::vector<OdometryPoint> OdometryTrack::usable(const OdometryChain& chain) const {
  if (worth_.position_m2 <= 0.0) return {};
  std::vector<OdometryPoint> points = pointsAt(delay_scans_), result;
  correct(worth_, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!result.empty()) i = nextUsable(points, result.back(), i, chain);
    result.push_back(points[i]);
  }
  return result;
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

void OdometryTrack::addTo(PoseGraph& graph, const OdometryChain& chain,
                          const std::vector<bool>& doubtful) const {
  const std::vector<OdometryPoint> points = usable(chain);
  const Eigen::Matrix3d pose_information =
      informationOf({worth_.position_m2, worth_.position_m2, worth_.yaw_rad2});
  std::vector<bool> weak(graph.vertices.size(), false);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t keyframe = points[i].keyframe, vertex = graph.vertices.size();
    graph.vertices.push_back({graph.vertices[keyframe].pose, false});
    graph.edges.push_back({vertex, keyframe, Pose2(), pose_information, EdgeKind::kLoop});
    if (i == 0 || chain.partOf(points[i - 1].keyframe) != chain.partOf(keyframe)) continue;
    graph.edges.push_back(edgeBetween(points[i - 1], points[i], vertex));
    if (agree(points[i - 1], points[i], chain, false)) continue;
    for (std::size_t k = points[i - 1].keyframe + 1; k <= keyframe; ++k) weak[k] = doubtful[k];
  }
  for (PoseEdge& edge : graph.edges)
    if (edge.kind == EdgeKind::kOdometry && weak[edge.to]) edge.information *= kWeak;
}

std::size_t OdometryTrack::memoryBytes() const {
  std::size_t bytes = keyframes_.capacity() * sizeof(TrackedKeyframe);
  for (const TrackedKeyframe& keyframe : keyframes_)
    bytes += keyframe.odometry.capacity() * sizeof(Pose2);
  return bytes;
}

}  // namespace kestrel
