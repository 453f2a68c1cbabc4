// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/pose_graph.h"

#include <gtest/gtest.h>

#include <limits>

#include "graph/graph_samples.h"

namespace kestrel {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

PoseGraph twoVertices() {
  PoseGraph graph;
  graph.vertices.resize(2);
  graph.edges.push_back({0, 1, Pose2(1.0, 0.0, 0.0), sampleInformation(), EdgeKind::kOdometry});
  return graph;
}

TEST(PoseGraph, ErrorOfAnEdgeIsThatOfG2o) {
  // measured⁻¹ (from⁻¹ to), by hand: `to` is at (2, 3) of `from`, which is (3, -1) of what was
  // measured at (1, 0) with a quarter turn.
  const Pose2 from(5.0, 5.0, kPi / 2.0), to = from * Pose2(2.0, 3.0, kPi / 2.0 + 0.1);
  const Eigen::Vector3d error = edgeError(Pose2(1.0, 0.0, kPi / 2.0), from, to);
  EXPECT_TRUE(error.isApprox(Eigen::Vector3d(3.0, -1.0, 0.1))) << error.transpose();
  PoseEdge edge{0, 1, Pose2(1.0, 0.0, kPi / 2.0), Eigen::Matrix3d::Identity(), EdgeKind::kLoop};
  edge.information.diagonal() << 1.0, 10.0, 100.0;
  EXPECT_NEAR(chi2Of(edge, from, to), 9.0 + 10.0 + 1.0, 1e-12);
}

TEST(PoseGraph, ErrorOfAnEdgeAgreesWithTheTangentSpaceOfTheMeasuredPose) {
  const Pose2 measured(1.0, 2.0, 0.7), from(-3.0, 0.5, 2.9);
  const Eigen::Vector3d t(1e-6, -2e-6, 3e-6);
  EXPECT_LT((edgeError(measured, from, from * measured * Pose2::exp(t)) - t).norm(), 1e-11);
}

TEST(PoseGraph, JacobiansAgreeWithFiniteDifferences) {
  constexpr double kStep = 1e-6;
  Random random(1);
  for (int sample = 0; sample < 50; ++sample) {
    const auto any = [&] {
      return Pose2(random.uniform(-9.0, 9.0), random.uniform(-9.0, 9.0), random.uniform(-3.0, 3.0));
    };
    const Pose2 measured = any(), from = any(), to = any();
    Eigen::Matrix3d J_from, J_to;
    const Eigen::Vector3d error = edgeError(measured, from, to, &J_from, &J_to);
    if (std::abs(error.z()) > 3.1) continue;  // the yaw wraps
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      const Eigen::Vector3d by_from = edgeError(measured, addOffset(from, step), to) - error;
      const Eigen::Vector3d by_to = edgeError(measured, from, addOffset(to, step)) - error;
      EXPECT_LT((by_from / kStep - J_from.col(i)).norm(), 1e-4);
      EXPECT_LT((by_to / kStep - J_to.col(i)).norm(), 1e-4);
    }
  }
}

TEST(PoseGraph, ProblemsAreNamed) {
  EXPECT_EQ(problemOf(twoVertices()), "");
  PoseGraph graph = twoVertices();
  graph.vertices[1].pose.x = kNan;
  EXPECT_EQ(problemOf(graph), "vertex 1: the pose is not finite");
  graph = twoVertices();
  graph.edges[0].to = 2;
  EXPECT_EQ(problemOf(graph), "edge 0: one of its vertices does not exist");
  graph.edges[0].to = 0;
  EXPECT_EQ(problemOf(graph), "edge 0: it leads from a vertex to the same vertex");
  graph = twoVertices();
  graph.edges[0].measured.yaw = kNan;
  EXPECT_EQ(problemOf(graph), "edge 0: the measured pose is not finite");
  for (const double bad : {0.0, -1.0, kNan}) {
    graph = twoVertices();
    graph.edges[0].information(1, 1) = bad;
    EXPECT_NE(problemOf(graph).find("positive definite"), std::string::npos) << bad;
  }
  graph = twoVertices();
  graph.edges[0].information(0, 1) = 1.0;
  EXPECT_NE(problemOf(graph).find("symmetric"), std::string::npos);
}

TEST(PoseGraph, EachConnectedPartHoldsAVertex) {
  PoseGraph graph;
  graph.vertices.resize(6);
  const auto connect = [&](std::size_t from, std::size_t to) {
    graph.edges.push_back({from, to, Pose2(), sampleInformation(), EdgeKind::kLoop});
  };
  connect(4, 1);
  connect(5, 2);
  connect(1, 0);
  EXPECT_EQ(connectedParts(graph), (std::vector<std::size_t>{0, 0, 2, 3, 0, 2}));
  EXPECT_EQ(heldVertices(graph), (std::vector<bool>{true, false, true, true, false, false}));
  graph.vertices[5].fixed = true;
  EXPECT_EQ(heldVertices(graph), (std::vector<bool>{true, false, false, true, false, true}));
}

}  // namespace
}  // namespace kestrel
