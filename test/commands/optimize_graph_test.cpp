// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "graph/graph_samples.h"
#include "kestrel_slam/graph/g2o_file.h"
#include "run_command.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr std::size_t kLap = 80;

Outcome optimizeGraph(const std::string& arguments) {
  return runCommand(std::string("'") + KESTREL_TOOL_DIR + "/optimize_graph' " + arguments);
}

TEST(OptimizeGraph, ImprovesAGraphAndKeepsItsIds) {
  Random random(1);
  const TemporaryFolder folder;
  const std::vector<Pose2> truth = squareDrive(3);
  G2oGraph file;
  file.graph = loopedGraph(truth, kLap, random);
  for (std::size_t i = 0; i < truth.size(); ++i) file.ids.push_back(static_cast<int>(3 * i));
  writeG2o(folder.file("in.g2o"), file);
  for (const char* option : {"", " --reinitialize", " --robust"}) {
    const Outcome outcome =
        optimizeGraph(folder.file("in.g2o") + " --output " + folder.file("out.g2o") + option);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    EXPECT_CONTAINS(outcome.output, "241 vertices, 401 edges, 161 of them loops");
    EXPECT_CONTAINS(outcome.output, "\nconverged after");
    const G2oGraph result = readG2o(folder.file("out.g2o"));
    EXPECT_EQ(result.ids, file.ids);
    EXPECT_LT(meanDistance(result.graph, truth), 1.0) << option;
  }
}

TEST(OptimizeGraph, RobustLeavesOutAFalseLoop) {
  Random random(2);
  const TemporaryFolder folder;
  const std::vector<Pose2> truth = squareDrive(3);
  G2oGraph file;
  file.graph = loopedGraph(truth, kLap, random);
  file.graph.edges.push_back({10, 130, Pose2(), sampleInformation(), EdgeKind::kLoop});
  writeG2o(folder.file("in.g2o"), file);
  const Outcome outcome =
      optimizeGraph(folder.file("in.g2o") + " --robust --output " + folder.file("out.g2o"));
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  const G2oGraph result = readG2o(folder.file("out.g2o"));
  EXPECT_LT(result.graph.edges.size(), file.graph.edges.size());
  for (const PoseEdge& edge : result.graph.edges) EXPECT_FALSE(edge.from == 10 && edge.to == 130);
  EXPECT_LT(meanDistance(result.graph, truth), 1.0);
}

TEST(OptimizeGraph, ReportsBadInput) {
  const TemporaryFolder folder;
  const std::string out = " --output " + folder.file("out.g2o");
  EXPECT_EQ(optimizeGraph("--help").code, 0);
  EXPECT_EQ(optimizeGraph("").code, 2);
  EXPECT_EQ(optimizeGraph(folder.file("a.g2o")).code, 2);
  EXPECT_EQ(optimizeGraph(folder.file("a.g2o") + " --robust --reinitialize" + out).code, 2);
  const Outcome missing = optimizeGraph(folder.file("a.g2o") + out);
  EXPECT_EQ(missing.code, 1);
  EXPECT_CONTAINS(missing.output, "optimize_graph: cannot read " + folder.file("a.g2o"));
  const std::string bad =
      folder.write("bad.g2o", "VERTEX_SE2 0 0 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
  const Outcome vertex = optimizeGraph(bad + out);
  EXPECT_EQ(vertex.code, 1);
  EXPECT_EQ(vertex.output, "optimize_graph: " + bad + ", line 2: there is no VERTEX_SE2 1\n");
  const std::string huge = folder.write(
      "huge.g2o", "VERTEX_SE2 0 1e200 0 0\nVERTEX_SE2 1 0 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
  const Outcome far = optimizeGraph(huge + out);
  EXPECT_EQ(far.code, 1);
  EXPECT_CONTAINS(far.output, "huge.g2o: the numbers are too large");
  EXPECT_FALSE(std::filesystem::exists(folder.file("out.g2o")));
  const std::string good =
      folder.write("good.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n");
  const Outcome nowhere = optimizeGraph(good + " --output /no/such/folder/a.g2o");
  EXPECT_EQ(nowhere.code, 1);
  EXPECT_CONTAINS(nowhere.output, "/no/such/folder");
}

}  // namespace
}  // namespace kestrel
