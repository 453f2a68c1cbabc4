// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/robust_optimizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "graph/graph_samples.h"
#include "kestrel_slam/graph/g2o_file.h"
#include "kestrel_slam/map/atomic_file.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

struct Count {
  std::size_t accepted = 0, all = 0;
};

Count countOf(const PoseGraph& graph, const RobustResult& result, std::size_t begin,
              std::size_t end) {
  Count count;
  for (std::size_t i = begin; i < end; ++i) {
    if (graph.edges[i].kind != EdgeKind::kLoop) continue;
    ++count.all;
    if (result.accepted[i]) ++count.accepted;
  }
  return count;
}

TEST(RobustOptimizer, AcceptsTrueLoopsAndRefusesTwiceAsManyFalseOnes) {
  Random random(1);
  const std::vector<Pose2> truth = squareDrive(3);
  PoseGraph graph = loopedGraph(truth, kLap, random);
  const std::size_t end = graph.edges.size();
  for (std::size_t i = 0; i < 4 * kLap; ++i) {
    const auto from = static_cast<std::size_t>(random.uniform() * 120.0);
    const auto to = from + 20 + static_cast<std::size_t>(random.uniform() * 40.0);
    const Pose2 near(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 0.0);
    graph.edges.push_back({from, to, near, sampleInformation(), EdgeKind::kLoop});
  }
  const RobustResult result = optimizeRobustly(graph);
  ASSERT_TRUE(result.optimizer.ok());
  const Count good = countOf(graph, result, 0, end);
  const Count bad = countOf(graph, result, end, graph.edges.size());
  EXPECT_GE(good.accepted, good.all * 98 / 100);
  EXPECT_EQ(bad.accepted, 0U) << "of " << bad.all;
  EXPECT_LT(meanDistance(graph, truth), 1.0);
}

TEST(RobustOptimizer, AcceptsNothingOfTwoSimilarExplanations) {
  Random random(2);
  const std::vector<Pose2> truth = squareDrive(2);
  PoseGraph graph = odometryGraph(truth, random);
  for (std::size_t i = 0; i < 8; ++i) {
    PoseEdge loop = measuredEdge(truth, i, kLap + i, EdgeKind::kLoop, random);
    graph.edges.push_back(loop);
    loop.measured = Pose2(0.0, 4.0, 0.0) * loop.measured;  // one door further
    graph.edges.push_back(loop);
  }
  const RobustResult result = optimizeRobustly(graph);
  EXPECT_GE(result.first, 7U);
  EXPECT_GE(result.second, 6U);
  EXPECT_EQ(countOf(graph, result, 0, graph.edges.size()).accepted, 0U);
}

TEST(RobustOptimizer, RefusesALoopThatOnlyVagueOdometrySupports) {
  Random random(3);
  PoseGraph graph = odometryGraph(squareDrive(2), random);
  graph.edges.push_back({3, 120, Pose2(1.0, 0.0, 0.0), sampleInformation(), EdgeKind::kLoop});
  EXPECT_FALSE(optimizeRobustly(graph).accepted.back());
}

TEST(RobustOptimizer, BadAndEmptyGraphs) {
  PoseGraph graph;
  EXPECT_TRUE(optimizeRobustly(graph).optimizer.ok());
  graph.vertices.resize(1);
  EXPECT_TRUE(optimizeRobustly(graph).optimizer.ok());
  graph.edges.push_back({0, 3, Pose2(), sampleInformation(), EdgeKind::kLoop});
  EXPECT_FALSE(optimizeRobustly(graph).optimizer.ok());
}

std::string textOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(RobustOptimizer, CsailAsTwoRobotsKeepsAll128TrueLoopsAndRefusesAll250FalseOnes) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const std::string folder = data + "/graph/CSAIL_";
  const std::string odometry = textOf(folder + "robot1.g2o") + "\n" + textOf(folder + "robot2.g2o");
  const std::size_t begin = parseG2o(odometry, "robots").graph.edges.size();
  PoseGraph graph =
      parseG2o(odometry + "\n" + textOf(folder + "interrobot_loop_closures_outliers.g2o"), "all")
          .graph;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    graph.edges[i].kind = i < begin ? EdgeKind::kOdometry : EdgeKind::kLoop;
  }
  ASSERT_EQ(graph.edges.size() - begin, 378U);
  const RobustResult result = optimizeRobustly(graph);
  EXPECT_EQ(countOf(graph, result, begin, begin + 128).accepted, 128U);  // the true ones are first
  EXPECT_EQ(countOf(graph, result, begin + 128, graph.edges.size()).accepted, 0U);
}

/// Two robots in one building, whose starts are unknown: 128 true loops, and 250 false ones.
TEST(RobustOptimizer, KeepsAllTrueLoopsOfTwoRobotsAndNoFalseOne) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const std::string folder = data + "/graph/CSAIL";
  const auto parsed = [&](const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += readFile(folder + name) + "\n";
    return parseG2o(text, folder).graph;
  };
  const std::size_t begin = parsed({"_robot1.g2o", "_robot2.g2o"}).edges.size();
  PoseGraph graph =
      parsed({"_robot1.g2o", "_robot2.g2o", "_interrobot_loop_closures_outliers.g2o"});
  for (std::size_t i = 0; i < graph.edges.size(); ++i)
    graph.edges[i].kind = i < begin ? EdgeKind::kOdometry : EdgeKind::kLoop;
  const RobustResult result = optimizeRobustly(graph);
  const Count good = countOf(graph, result, begin, begin + 128);
  const Count bad = countOf(graph, result, begin + 128, graph.edges.size());
  EXPECT_EQ(good.accepted, 128U);
  EXPECT_EQ(bad.all, 250U);
  EXPECT_EQ(bad.accepted, 0U);
}

}  // namespace
}  // namespace kestrel
