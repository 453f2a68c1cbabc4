// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/initial_poses.h"

#include <gtest/gtest.h>

#include "graph/graph_samples.h"

namespace kestrel {
namespace {

TEST(InitialPoses, AlongEdgesPutsAFixedVertexAndAllOthersRight) {
  Random random(1);
  const std::vector<Pose2> truth = squareDrive(1);
  PoseGraph graph = loopedGraph(truth, 40, random);
  for (PoseEdge& edge : graph.edges) edge.measured = truth[edge.from].between(truth[edge.to]);
  graph.edges.erase(graph.edges.begin() + 30);  // only loops join the halves
  for (PoseVertex& vertex : graph.vertices) vertex.pose = Pose2();
  graph.vertices[5] = {truth[5], true};
  placeAlongEdges(graph);
  EXPECT_LT(meanDistance(graph, truth), 1e-9);
}

TEST(InitialPoses, ByRotationsNeedsNoGuess) {
  Random random(2);
  const std::vector<Pose2> truth = squareDrive(3);
  PoseGraph graph = loopedGraph(truth, kLap, random);
  for (PoseVertex& vertex : graph.vertices) vertex.pose = Pose2();
  ASSERT_TRUE(placeByRotations(graph));
  EXPECT_LT(meanDistance(graph, truth), 1.5);  // the odometry alone: 6 m
  for (PoseEdge& edge : graph.edges) edge.measured = truth[edge.from].between(truth[edge.to]);
  ASSERT_TRUE(placeByRotations(graph));
  EXPECT_LT(meanDistance(graph, truth), 1e-6);
}

TEST(InitialPoses, ByRotationsRefusesABadGraph) {
  PoseGraph graph;
  graph.vertices.resize(2);
  graph.edges.push_back({0, 5, Pose2(), sampleInformation(), EdgeKind::kLoop});
  EXPECT_FALSE(placeByRotations(graph));
}

}  // namespace
}  // namespace kestrel
