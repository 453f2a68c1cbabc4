// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/marginals.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "graph/graph_samples.h"
#include "kestrel_slam/graph/optimizer.h"

namespace kestrel {
namespace {

TEST(Marginals, OfAChainAreTheComposedCovariances) {
  Random random(1);
  const PoseGraph graph = odometryGraph(squareDrive(1), random);
  GaussianPose2 expected;
  for (std::size_t i = 5; i < 40; ++i) {
    const PoseEdge& edge = graph.edges[i];
    expected = compose(expected, {edge.measured, edge.information.inverse()});
  }
  const auto forward = marginals(graph, {}, 5, {40});
  ASSERT_TRUE(forward[0]);
  EXPECT_LT((forward[0]->mean.between(expected.mean)).log().norm(), 1e-9);
  EXPECT_TRUE(forward[0]->covariance.isApprox(expected.covariance, 1e-6));
  const auto backward = marginals(graph, {}, 40, {5, 40});
  ASSERT_TRUE(backward[0] && backward[1]);
  EXPECT_TRUE(backward[0]->covariance.isApprox(inverse(expected).covariance, 1e-6));
  EXPECT_LT(backward[1]->covariance.norm(), 1e-9);
}

TEST(Marginals, DoNotDependOnTheHeldVertex) {
  Random random(2);
  PoseGraph graph = loopedGraph(squareDrive(2), kLap, random);
  optimize(graph);
  const auto free = marginals(graph, {}, 60, {100});
  graph.vertices[60].fixed = true;
  const auto fixed = marginals(graph, {}, 60, {100});
  ASSERT_TRUE(free[0] && fixed[0]);
  EXPECT_TRUE(free[0]->covariance.isApprox(fixed[0]->covariance, 1e-6));
}

TEST(Marginals, ShrinkWhenALoopClosesAndHardlyByALoopWithoutWeight) {
  Random random(3);
  const std::vector<Pose2> truth = squareDrive(1);
  PoseGraph graph = odometryGraph(truth, random);
  const auto open = marginals(graph, {}, 0, {kLap});
  graph.edges.push_back(measuredEdge(truth, 0, kLap, EdgeKind::kLoop, random));
  optimize(graph);
  const auto closed = marginals(graph, {}, 0, {kLap});
  std::vector<double> weights(graph.edges.size(), 1.0);
  weights.back() = 1e-9;
  const auto ignored = marginals(graph, weights, 0, {kLap});
  EXPECT_LT(closed[0]->covariance.determinant(), 1e-3 * open[0]->covariance.determinant());
  EXPECT_GT(ignored[0]->covariance.determinant(), 0.5 * open[0]->covariance.determinant());
}

TEST(Marginals, DescribeTheErrorsOfTheOptimum) {
  constexpr int kRuns = 60;
  const std::vector<Pose2> truth = squareDrive(2);
  double nees = 0.0;
  Random random(4);
  for (int run = 0; run < kRuns; ++run) {
    PoseGraph graph = loopedGraph(truth, kLap, random);
    optimize(graph, {0.0});
    const auto result = marginals(graph, {}, 20, {130});
    const Eigen::Vector3d error = result[0]->mean.between(truth[20].between(truth[130])).log();
    nees += error.dot(result[0]->covariance.inverse() * error) / kRuns;
  }
  EXPECT_NEAR(nees, 3.0, 4.0 * std::sqrt(6.0 / kRuns));
}

TEST(Marginals, AreTheSameWithTheCovariancesOfTheInformation) {
  Random random(6);
  PoseGraph graph = loopedGraph(squareDrive(2), kLap, random);
  optimize(graph);
  std::vector<Eigen::Matrix3d> covariances;
  for (const PoseEdge& edge : graph.edges) covariances.push_back(edge.information.inverse());
  const GraphMarginals joint(graph, {});
  const auto expected = joint.between(20, 130), found = joint.between(20, 130, covariances);
  ASSERT_TRUE(expected && found);
  EXPECT_EQ(found->mean, expected->mean);
  EXPECT_TRUE(found->covariance.isApprox(expected->covariance, 1e-6));
}

/// The optimizer takes the loops for five times worse than they are.
TEST(Marginals, DescribeTheErrorsOfAnOptimumWithOtherWeights) {
  constexpr int kRuns = 60;
  constexpr double kFactor = 25.0;
  const std::vector<Pose2> truth = squareDrive(2);
  double nees = 0.0;
  Random random(7);
  for (int run = 0; run < kRuns; ++run) {
    PoseGraph graph = loopedGraph(truth, kLap, random);
    std::vector<Eigen::Matrix3d> covariances;
    for (PoseEdge& edge : graph.edges) {
      covariances.push_back(edge.information.inverse());
      if (edge.kind == EdgeKind::kLoop) edge.information /= kFactor;
    }
    optimize(graph, {0.0});
    const auto result = GraphMarginals(graph, {}).between(20, 130, covariances);
    const Eigen::Vector3d error = result->mean.between(truth[20].between(truth[130])).log();
    nees += error.dot(result->covariance.inverse() * error) / kRuns;
  }
  EXPECT_NEAR(nees, 3.0, 4.0 * std::sqrt(6.0 / kRuns));
}

TEST(Marginals, AreUnknownBetweenPartsThatAreNotConnected) {
  Random random(5);
  PoseGraph graph = odometryGraph(squareDrive(1), random);
  graph.edges.erase(graph.edges.begin() + 30);
  auto result = marginals(graph, {}, 0, {10, 50});
  EXPECT_TRUE(result[0]);
  EXPECT_FALSE(result[1]);
  graph.vertices[0].fixed = graph.vertices[40].fixed = true;
  result = marginals(graph, {}, 5, {50});
  ASSERT_TRUE(result[0]);
  EXPECT_TRUE(result[0]->covariance.allFinite());
  graph.edges[0].information.setZero();
  EXPECT_FALSE(marginals(graph, {}, 0, {10})[0]);
}

}  // namespace
}  // namespace kestrel
