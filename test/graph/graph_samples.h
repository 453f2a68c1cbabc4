// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/graph/pose_graph.h"

namespace kestrel {

/// 5 cm and 2 degrees.
inline Eigen::Matrix3d sampleInformation() {
  return Eigen::Vector3d(400.0, 400.0, 820.0).asDiagonal();
}

inline Pose2 noise(Random& random, const Eigen::Matrix3d& information) {
  const Eigen::Vector3d sigmas = information.diagonal().cwiseInverse().cwiseSqrt();
  return Pose2::exp(sigmas.cwiseProduct(
      Eigen::Vector3d(random.gaussian(), random.gaussian(), random.gaussian())));
}

inline PoseEdge measuredEdge(const std::vector<Pose2>& truth, std::size_t from, std::size_t to,
                             EdgeKind kind, Random& random) {
  const Eigen::Matrix3d information = sampleInformation();
  return {from, to, truth[from].between(truth[to]) * noise(random, information), information, kind};
}

constexpr std::size_t kSide = 20, kLap = 4 * kSide;  ///< m, and poses of squareDrive()

/// `laps` times round a square of 20 m with a pose every meter.
inline std::vector<Pose2> squareDrive(std::size_t laps) {
  std::vector<Pose2> truth = {Pose2()};
  for (std::size_t i = 1; i <= kLap * laps; ++i) {
    truth.push_back(truth.back() * Pose2(1.0, 0.0, i % kSide == 0 ? kPi / 2.0 : 0.0));
  }
  return truth;
}

/// The drive as a graph: noisy odometry from pose to pose, the vertices at the poses that it gives.
inline PoseGraph odometryGraph(const std::vector<Pose2>& truth, Random& random) {
  PoseGraph graph;
  graph.vertices.push_back({truth.front()});
  for (std::size_t i = 1; i < truth.size(); ++i) {
    graph.edges.push_back(measuredEdge(truth, i - 1, i, EdgeKind::kOdometry, random));
    graph.vertices.push_back({graph.vertices.back().pose * graph.edges.back().measured});
  }
  return graph;
}

/// The same with a loop from every pose of each lap to that of the lap before.
inline PoseGraph loopedGraph(const std::vector<Pose2>& truth, std::size_t lap, Random& random) {
  PoseGraph graph = odometryGraph(truth, random);
  for (std::size_t i = lap; i < truth.size(); ++i) {
    graph.edges.push_back(measuredEdge(truth, i - lap, i, EdgeKind::kLoop, random));
  }
  return graph;
}

inline double meanDistance(const PoseGraph& graph, const std::vector<Pose2>& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    sum += (graph.vertices[i].pose.translation() - truth[i].translation()).norm();
  }
  return sum / static_cast<double>(truth.size());
}

}  // namespace kestrel
