// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/g2o_file.h"

#include <gtest/gtest.h>

#include <chrono>

#include "graph/graph_samples.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

const std::string kVertices = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n";
const std::string kInformation = " 10 0 0 10 0 100\n";

std::string problemIn(const std::string& text) {
  return messageOf([&] { parseG2o(text, "a.g2o"); });
}

TEST(G2oFile, ReadsVerticesEdgesAndFixedInAnyOrder) {
  const G2oGraph file = parseG2o(
      "# a comment\r\n\nFIX 7 20 # both\nEDGE_SE2 7 3 1 2 3.5 1 0.1 0.2 2 0.3 3\r\n"
      "VERTEX_SE2 20 4 5 6\n  VERTEX_SE2\t3  1 2 3\nEDGE_SE2 20 3 0 0 0" +
          kInformation + "VERTEX_SE2 7 -1e-1 0x1p1 0",
      "a.g2o");
  EXPECT_EQ(file.ids, (std::vector<std::int64_t>{3, 7, 20}));
  const PoseGraph& graph = file.graph;
  ASSERT_EQ(graph.edges.size(), 2U);
  EXPECT_EQ(graph.vertices[0].pose, Pose2(1.0, 2.0, 3.0));
  EXPECT_EQ(graph.vertices[1].pose, Pose2(-0.1, 2.0, 0.0));
  EXPECT_FALSE(graph.vertices[0].fixed);
  EXPECT_TRUE(graph.vertices[1].fixed && graph.vertices[2].fixed);
  EXPECT_EQ(graph.edges[0].from, 1U);
  EXPECT_EQ(graph.edges[0].to, 0U);
  EXPECT_EQ(graph.edges[0].measured, Pose2(1.0, 2.0, 3.5));
  Eigen::Matrix3d information;
  information << 1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 3.0;
  EXPECT_EQ(graph.edges[0].information, information);
  EXPECT_EQ(graph.edges[0].kind, EdgeKind::kOdometry);
  EXPECT_EQ(graph.edges[1].kind, EdgeKind::kLoop);
}

TEST(G2oFile, WithoutVerticesPlacesThemAlongTheEdges) {
  const G2oGraph file =
      parseG2o("EDGE_SE2 5 6 1 0 1.5707963267948966" + kInformation + "EDGE_SE2 6 7 1 0 0" +
                   kInformation + "EDGE_SE2 5 7 9 9 9" + kInformation,
               "a.g2o");
  ASSERT_EQ(file.graph.vertices.size(), 3U);
  EXPECT_NEAR(file.graph.vertices[2].pose.x, 1.0, 1e-12);
  EXPECT_NEAR(file.graph.vertices[2].pose.y, 1.0, 1e-12);
}

TEST(G2oFile, RoundTripIsExact) {
  Random random(1);
  const TemporaryFolder folder;
  G2oGraph written;
  written.graph = loopedGraph(squareDrive(2), 80, random);
  written.graph.vertices[3].fixed = true;
  for (PoseEdge& edge : written.graph.edges) edge.information(0, 1) = edge.information(1, 0) = 0.1;
  for (std::size_t i = 0; i < written.graph.vertices.size(); ++i) {
    written.ids.push_back(static_cast<std::int64_t>(10 * i + i % 2));
  }
  writeG2o(folder.file("a.g2o"), written);
  const G2oGraph read = readG2o(folder.file("a.g2o"));
  EXPECT_EQ(read.ids, written.ids);
  ASSERT_EQ(read.graph.edges.size(), written.graph.edges.size());
  for (std::size_t i = 0; i < read.ids.size(); ++i) {
    EXPECT_EQ(read.graph.vertices[i].pose, written.graph.vertices[i].pose);
    EXPECT_EQ(read.graph.vertices[i].fixed, written.graph.vertices[i].fixed);
  }
  for (std::size_t i = 0; i < read.graph.edges.size(); ++i) {
    const PoseEdge &a = read.graph.edges[i], &b = written.graph.edges[i];
    EXPECT_TRUE(a.from == b.from && a.to == b.to && a.measured == b.measured && a.kind == b.kind &&
                a.information == b.information);
  }
  EXPECT_EQ(g2oText(read), g2oText(written));
}

TEST(G2oFile, ErrorsNameLineAndCause) {
  const std::string edge = "EDGE_SE2 0 1 1 0 0";
  EXPECT_EQ(problemIn(""), "a.g2o: the file has no VERTEX_SE2 and no EDGE_SE2");
  EXPECT_EQ(problemIn(kVertices + "EDGE_SE2 0 1 nan 0 0" + kInformation),
            "a.g2o, line 3: 'nan' is not a finite number");
  EXPECT_CONTAINS(problemIn(kVertices + "VERTEX_SE2 2 1e999 0 0\n"), "line 3: '1e999' is not");
  EXPECT_CONTAINS(problemIn(kVertices + "VERTEX_SE2 2 1,5 0 0\n"), "line 3: '1,5' is not");
  EXPECT_EQ(problemIn(kVertices + "EDGE_SE2 0 2 1 0 0" + kInformation),
            "a.g2o, line 3: there is no VERTEX_SE2 2");
  EXPECT_EQ(problemIn(kVertices + "FIX 9\n"), "a.g2o, line 3: there is no VERTEX_SE2 9");
  EXPECT_EQ(problemIn(kVertices + edge + " 1 0 0 1 0\n"), "a.g2o, line 3: too few numbers");
  EXPECT_EQ(problemIn(kVertices + edge + " 1 0 0 1 0 1 7\n"),
            "a.g2o, line 3: '7' after the last number");
  EXPECT_CONTAINS(problemIn(kVertices + edge + " 1 0 0 -1 0 1\n"), "line 3: bad edge: the inform");
  EXPECT_CONTAINS(problemIn(kVertices + edge + " 1 2 0 1 0 1\n"), "positive definite");
  EXPECT_CONTAINS(problemIn(kVertices + edge + " 0 0 0 0 0 0\n"), "positive definite");
  EXPECT_CONTAINS(problemIn(kVertices + "EDGE_SE2 1 1 1 0 0" + kInformation), "the same vertex");
  EXPECT_EQ(problemIn(kVertices + "VERTEX_SE2 0 0 0 0\n"),
            "a.g2o, line 3: vertex 0 is already in line 1");
  EXPECT_CONTAINS(problemIn("VERTEX_SE2 -1 0 0 0\n"), "'-1' is not the id of a vertex");
  EXPECT_CONTAINS(problemIn("VERTEX_SE2 1.5 0 0 0\n"), "'1.5' is not the id of a vertex");
  EXPECT_CONTAINS(problemIn("VERTEX_SE2 99999999999999999999 0 0 0\n"), "is not the id");
  EXPECT_CONTAINS(problemIn("VERTEX_SE2 0 0 0\nVERTEX_SE2 1 0 0 0"), "line 1: too few numbers");
  EXPECT_CONTAINS(problemIn("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"),
                  "'VERTEX_SE3:QUAT' is not supported, only VERTEX_SE2, EDGE_SE2 and FIX");
  EXPECT_CONTAINS(problemIn(std::string("\xfd"
                                        "7zXZ\0\0\0",
                                        8)),
                  "line 1: '?7zXZ");
  EXPECT_CONTAINS(messageOf([] { readG2o("/no/such.g2o"); }), "/no/such.g2o");
}

TEST(G2oFile, AnyPrefixAndAnyFlippedByteGivesAGraphOrAReason) {
  Random random(2);
  G2oGraph file;
  file.graph = odometryGraph({Pose2(), Pose2(1.0, 0.0, 0.5), Pose2(2.0, 0.0, 0.0)}, random);
  file.graph.vertices[1].fixed = true;
  const std::string text = g2oText(file);
  for (std::size_t i = 0; i < text.size(); ++i) {
    EXPECT_FALSE(problemIn(text.substr(0, i)).empty());
    for (const char wrong : {' ', '-', 'n', '\0', '\n', '9', '\x80'}) {
      std::string damaged = text;
      damaged[i] = wrong;
      EXPECT_FALSE(problemIn(damaged).empty());
    }
  }
}

TEST(G2oFile, AMillionEdgesTakeSeconds) {
  constexpr int kVertexCount = 20'000, kEdgeCount = 1'000'000;
  std::string text;
  for (int i = 0; i < kVertexCount; ++i)
    text += "VERTEX_SE2 " + std::to_string(i) + " 1.5 2.5 0.1\n";
  for (int i = 0; i < kEdgeCount; ++i) {
    text += "EDGE_SE2 " + std::to_string(i % kVertexCount) + " " +
            std::to_string((7 * i + 1) % kVertexCount) + " 0.123456 -0.234567 0.5" + kInformation;
  }
  // The edge of i to itself does not exist: 6 i + 1 is never a multiple of an even number.
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(parseG2o(text, "a.g2o").graph.edges.size(), 1'000'000U);
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
  std::printf("%.2f s\n", time.count());
  EXPECT_LT(time.count(), 20.0);
  EXPECT_CONTAINS(problemIn(text + "EDGE_SE2 0 1 1 0 0 1 0 0 1 0\n"), "line 1020001: too few");
}

}  // namespace
}  // namespace kestrel
