// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/graph_uncertainty.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

PoseEdge step(std::size_t from, std::size_t to, EdgeKind kind = EdgeKind::kOdometry) {
  return {from, to, Pose2(1.0, 0.0, 0.0),
          Eigen::Vector3d(1.0 / 0.01, 1.0 / 0.01, 1.0 / 0.0001).asDiagonal(), kind};
}

PoseGraph chainOf(std::size_t vertices) {
  PoseGraph graph;
  for (std::size_t i = 0; i < vertices; ++i) {
    graph.vertices.push_back({Pose2(static_cast<double>(i), 0.0, 0.0), false});
    if (i > 0) graph.edges.push_back(step(i - 1, i));
  }
  return graph;
}

TEST(GraphUncertainty, GrowsWithEachEdge) {
  const PoseGraph graph = chainOf(11);
  const auto from = uncertaintiesFrom(graph, 0);
  EXPECT_EQ(from[0].position_m2, 0.0);
  double lever = 0.0;
  for (int left = 0; left < 10; ++left) lever += left * left;
  const double expected = 10 * 0.02 + lever * 0.0001;
  EXPECT_NEAR(from[10].position_m2, expected, 1e-9);
  EXPECT_NEAR(from[10].yaw_rad2, 10 * 0.0001, 1e-9);
  EXPECT_NEAR(from[10].sigmaAt(3.0), std::sqrt(expected + 9.0 * 0.001), 1e-9);
}

TEST(GraphUncertainty, ALoopIsAShorterPath) {
  PoseGraph graph = chainOf(11);
  graph.edges.push_back(step(1, 9, EdgeKind::kLoop));
  const auto from = uncertaintiesFrom(graph, 0);
  const double levers = (81 + 1) * 0.0001;  // of the first edge and of the loop, m²
  EXPECT_NEAR(from[10].position_m2, 3 * 0.02 + levers, 1e-9);
  EXPECT_NEAR(from[8].position_m2, 3 * 0.02 + (49 + 1) * 0.0001, 1e-9);
}

TEST(GraphUncertainty, AnotherPartIsUnknown) {
  PoseGraph graph = chainOf(4);
  graph.edges.pop_back();
  EXPECT_GT(uncertaintiesFrom(graph, 0)[3].sigmaAt(0.0), 1e3);
}

}  // namespace
}  // namespace kestrel
