// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/optimizer.h"

#include <gtest/gtest.h>

#include <numeric>

#include "graph/graph_samples.h"

namespace kestrel {
namespace {

double sumOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(Optimizer, ClosesALoop) {
  Random random(1);
  const std::vector<Pose2> truth = squareDrive(5);
  PoseGraph graph = loopedGraph(truth, kLap, random);
  const double before = meanDistance(graph, truth);
  const OptimizerResult result = optimize(graph);
  ASSERT_TRUE(result.ok()) << result.problem;
  EXPECT_TRUE(result.converged);
  EXPECT_LT(result.final_cost, result.initial_cost);
  EXPECT_LT(meanDistance(graph, truth), 0.6);
  EXPECT_LT(meanDistance(graph, truth), 0.2 * before);
  EXPECT_EQ(graph.vertices[0].pose, truth[0]);
}

TEST(Optimizer, Chi2AtTheOptimumFollowsItsDistribution) {
  Random random(2);
  const std::vector<Pose2> truth = squareDrive(5);
  PoseGraph graph = loopedGraph(truth, kLap, random);
  OptimizerOptions options;
  options.kernel_scale = 0.0;
  const OptimizerResult result = optimize(graph, options);
  const double freedom = 3.0 * static_cast<double>(graph.edges.size() - graph.vertices.size() + 1);
  EXPECT_NEAR(sumOf(result.edge_chi2), freedom, 5.0 * std::sqrt(2.0 * freedom));
  EXPECT_NEAR(sumOf(result.edge_chi2), result.final_cost, 1e-9 * freedom);
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    EXPECT_EQ(result.edge_chi2[i], chi2Of(graph.edges[i], graph)) << i;
    EXPECT_EQ(result.edge_weights[i], 1.0);
  }
}

TEST(Optimizer, ATrueLoopClosesALargeErrorAndIsNotRejected) {
  Random random(3);
  const std::vector<Pose2> truth = squareDrive(1);
  PoseGraph graph = odometryGraph(truth, random);
  // A turn that the odometry missed by 20 degrees: 10 standard deviations of one edge.
  graph.edges[20].measured = graph.edges[20].measured * Pose2(0.0, 0.0, 0.35);
  for (std::size_t i = 1; i < truth.size(); ++i) {
    graph.vertices[i].pose = graph.vertices[i - 1].pose * graph.edges[i - 1].measured;
  }
  graph.edges.push_back(measuredEdge(truth, 0, kLap, EdgeKind::kLoop, random));
  ASSERT_GT(chi2Of(graph.edges.back(), graph), 10000.0);
  const OptimizerResult result = optimize(graph);
  EXPECT_LT(result.edge_chi2.back(), 10.0);
  EXPECT_GT(result.edge_weights.back(), 0.5);
}

TEST(Optimizer, AFalseLoopLosesItsWeight) {
  Random random(4);
  const std::vector<Pose2> truth = squareDrive(3);
  PoseGraph graph = loopedGraph(truth, kLap, random);
  optimize(graph);
  const double clean = meanDistance(graph, truth);
  PoseEdge wrong = measuredEdge(truth, 10, 50, EdgeKind::kLoop, random);
  wrong.measured = Pose2();
  graph.edges.push_back(wrong);
  const OptimizerResult result = optimize(graph);
  EXPECT_LT(result.edge_weights.back(), 0.001);
  EXPECT_LT(meanDistance(graph, truth), clean + 0.05);
}

TEST(Optimizer, FixedVerticesStay) {
  Random random(5);
  const std::vector<Pose2> truth = squareDrive(2);
  PoseGraph graph = loopedGraph(truth, kLap, random);
  graph.vertices[30].pose = truth[30];
  graph.vertices[30].fixed = true;
  optimize(graph);
  EXPECT_EQ(graph.vertices[30].pose, truth[30]);
  EXPECT_FALSE(graph.vertices[0].pose == truth[0]);
}

TEST(Optimizer, TheSameGraphInAnotherFrameGivesTheSameShape) {
  Random random(6);
  const Pose2 other(100.0, -50.0, 3.0);
  PoseGraph a = loopedGraph(squareDrive(2), kLap, random), b = a;
  for (PoseVertex& vertex : b.vertices) vertex.pose = other * vertex.pose;
  optimize(a);
  optimize(b);
  for (std::size_t i = 0; i < a.vertices.size(); ++i) {
    const Pose2 difference = (other * a.vertices[i].pose).between(b.vertices[i].pose);
    EXPECT_LT(difference.log().norm(), 1e-4) << i;
  }
}

TEST(Optimizer, IsolatedVerticesAndEmptyGraphsAreFine) {
  PoseGraph graph;
  EXPECT_TRUE(optimize(graph).ok());
  graph.vertices.resize(3);
  graph.vertices[2].pose = Pose2(1.0, 2.0, 3.0);
  EXPECT_TRUE(optimize(graph).ok());
  EXPECT_EQ(graph.vertices[2].pose, Pose2(1.0, 2.0, 3.0));
  graph.vertices[0].fixed = graph.vertices[1].fixed = true;
  graph.edges.push_back({0, 1, Pose2(), sampleInformation(), EdgeKind::kLoop});
  EXPECT_TRUE(optimize(graph).ok());
}

TEST(Optimizer, RefusesABadGraphAndLeavesIt) {
  PoseGraph graph;
  graph.vertices.resize(2);
  graph.edges.push_back({0, 7, Pose2(), sampleInformation(), EdgeKind::kLoop});
  const OptimizerResult result = optimize(graph);
  EXPECT_EQ(result.problem, "edge 0: one of its vertices does not exist");
}

TEST(Optimizer, ExtremeNumbersGiveAResultOrAReason) {
  for (const double scale : {1e-150, 1e-20, 1e20, 1e150, 1e300}) {
    PoseGraph graph;
    graph.vertices.resize(2);
    graph.edges.push_back(
        {0, 1, Pose2(scale, 0.0, 0.0), scale * sampleInformation(), EdgeKind::kLoop});
    optimize(graph);
    EXPECT_TRUE(graph.vertices[1].pose.isFinite()) << scale;
  }
}

TEST(Optimizer, IsDeterministicAndNeedsFewSteps) {
  Random random(7);
  PoseGraph a = loopedGraph(squareDrive(25), kLap, random);  // 2001 vertices, 3921 edges
  PoseGraph b = a;
  const OptimizerResult first = optimize(a);
  EXPECT_LT(first.iterations, 25);
  const OptimizerResult second = optimize(b);
  EXPECT_EQ(first.final_cost, second.final_cost);
  for (std::size_t i = 0; i < a.vertices.size(); ++i) {
    EXPECT_EQ(a.vertices[i].pose, b.vertices[i].pose);
  }
}

}  // namespace
}  // namespace kestrel
