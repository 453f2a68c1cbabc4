// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/pairwise_consistency.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>

#include "../../src/graph/maximum_clique.h"
#include "graph/graph_samples.h"
#include "kestrel_slam/geometry/pose_covariance.h"

namespace kestrel {
namespace {

constexpr std::size_t kWork = 10'000'000;

std::vector<std::size_t> range(std::size_t begin, std::size_t end) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = begin; i < end; ++i) numbers.push_back(i);
  return numbers;
}

PoseEdge shifted(PoseEdge loop, double x) {
  loop.measured = Pose2(0.0, x, 0.0) * loop.measured;
  return loop;
}

TEST(OdometryChain, NoiseIsThatOfTheComposedEdges) {
  Random random(1);
  const PoseGraph graph = odometryGraph(squareDrive(2), random);
  const OdometryChain chain(graph);
  GaussianPose2 expected;
  for (std::size_t i = 33; i < 120; ++i) {
    expected = compose(expected, {graph.edges[i].measured, graph.edges[i].information.inverse()});
  }
  const Eigen::Matrix3d adjoint = chain.pose(120).inverse().adjoint();
  EXPECT_TRUE((adjoint * chain.noiseBetween(33, 120) * adjoint.transpose())
                  .isApprox(expected.covariance, 1e-9));
  EXPECT_LT(chain.pose(33).between(chain.pose(120)).between(expected.mean).log().norm(), 1e-9);
}

TEST(OdometryChain, GrowsAndBeginsAPartWhereAnEdgeIsMissing) {
  Random random(2);
  PoseGraph whole = odometryGraph(squareDrive(1), random), graph;
  whole.edges.erase(whole.edges.begin() + 49);
  graph.vertices.assign(whole.vertices.begin(), whole.vertices.begin() + 20);
  graph.edges.assign(whole.edges.begin(), whole.edges.begin() + 19);
  OdometryChain chain(graph);
  EXPECT_EQ(chain.size(), 20U);
  chain.grow(whole);
  const OdometryChain at_once(whole);
  ASSERT_EQ(chain.size(), whole.vertices.size());
  EXPECT_EQ(chain.partOf(49), 0U);
  EXPECT_EQ(chain.partOf(50), 1U);
  EXPECT_EQ(chain.pose(50), Pose2());
  for (std::size_t i = 0; i < chain.size(); ++i) EXPECT_EQ(chain.pose(i), at_once.pose(i));
}

TEST(OdometryChain, EdgesMayLeadBackward) {
  Random random(11);
  const PoseGraph forward = odometryGraph(squareDrive(1), random);
  PoseGraph backward = forward;
  for (PoseEdge& edge : backward.edges) {
    const GaussianPose2 turned = inverse(GaussianPose2{edge.measured, edge.information.inverse()});
    edge = {edge.to, edge.from, turned.mean, turned.covariance.inverse(), edge.kind};
  }
  const OdometryChain a(forward), b(backward);
  EXPECT_LT(a.pose(70).between(b.pose(70)).log().norm(), 1e-9);
  EXPECT_TRUE(a.noiseBetween(20, 70).isApprox(b.noiseBetween(20, 70), 1e-9));
}

/// The mean of chi2 over many samples of the same two true loops.
double meanChi2(std::size_t from_a, std::size_t to_a, std::size_t from_b, std::size_t to_b) {
  constexpr int kRuns = 400;
  const std::vector<Pose2> truth = squareDrive(2);
  Random random(3);
  double sum = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const OdometryChain chain(odometryGraph(truth, random));
    const PoseEdge a = measuredEdge(truth, from_a, to_a, EdgeKind::kLoop, random);
    const PoseEdge b = measuredEdge(truth, from_b, to_b, EdgeKind::kLoop, random);
    sum += checkCycle(a, b, chain)->chi2;
  }
  return sum / kRuns;
}

TEST(CycleCheck, HasThreeDegreesOfFreedomForTrueLoops) {
  constexpr double kTolerance = 4.0 * 0.125;  // 4 standard deviations of the mean
  EXPECT_NEAR(meanChi2(10, 90, 15, 93), 3.0, kTolerance);
  EXPECT_NEAR(meanChi2(90, 10, 15, 93), 3.0, kTolerance);  // opposite directions
  EXPECT_NEAR(meanChi2(10, 90, 12, 30), 3.0, kTolerance);  // overlapping odometry
  EXPECT_NEAR(meanChi2(10, 15, 60, 65), 3.0, kTolerance);  // the odometry between them cancels out
  EXPECT_NEAR(meanChi2(10, 90, 10, 90), 3.0, kTolerance);  // no odometry
}

TEST(CycleCheck, OfOneLoopComparesItWithTheOdometry) {
  Random random(4);
  const std::vector<Pose2> truth = squareDrive(1);
  double sum = 0.0;
  for (int run = 0; run < 400; ++run) {
    const OdometryChain chain(odometryGraph(truth, random));
    sum += checkCycle(measuredEdge(truth, 30, 5, EdgeKind::kLoop, random), chain)->chi2;
  }
  EXPECT_NEAR(sum / 400.0, 3.0, 0.5);
}

TEST(MaximumClique, AgreesWithBruteForce) {
  constexpr std::size_t kSize = 14;
  Random random(5);
  for (int sample = 0; sample < 40; ++sample) {
    std::vector<BitSet> rows(kSize, BitSet(kSize));
    const double density = random.uniform(0.1, 0.9);
    for (std::size_t i = 0; i < kSize; ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        if (random.uniform() > density) continue;
        rows[i].insert(k);
        rows[k].insert(i);
      }
    }
    const auto isClique = [&](const std::vector<std::size_t>& set) {
      return std::all_of(set.begin(), set.end(), [&](std::size_t i) {
        return std::all_of(set.begin(), set.end(),
                           [&](std::size_t k) { return i == k || rows[i].contains(k); });
      });
    };
    std::size_t largest = 0;
    for (unsigned mask = 0; mask < 1U << kSize; ++mask) {
      std::vector<std::size_t> set;
      for (std::size_t i = 0; i < kSize; ++i) {
        if ((mask >> i & 1U) != 0) set.push_back(i);
      }
      if (set.size() > largest && isClique(set)) largest = set.size();
    }
    const Clique clique = maximumClique(rows, kWork);
    EXPECT_TRUE(clique.exact);
    EXPECT_TRUE(isClique(clique.members));
    EXPECT_EQ(clique.members.size(), largest) << sample;
  }
}

TEST(MaximumClique, EndsAtTheWorkLimitWithAUsefulSet) {
  constexpr std::size_t kSize = 1000, kHidden = 100;
  Random random(6);
  std::vector<BitSet> rows(kSize, BitSet(kSize));
  for (std::size_t i = 0; i < kSize; ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (i >= kHidden && random.uniform() > 0.5) continue;
      rows[i].insert(k);
      rows[k].insert(i);
    }
  }
  const Clique clique = maximumClique(rows, kWork);
  EXPECT_GE(clique.members.size(), kHidden);
  EXPECT_TRUE(maximumClique({}, kWork).members.empty());
}

TEST(ConsistentLoops, FindsTheTrueLoopsAmongFalseOnes) {
  Random random(7);
  const std::vector<Pose2> truth = squareDrive(3);
  const OdometryChain chain(odometryGraph(truth, random));
  ConsistentLoops loops;
  for (std::size_t i = 0; i < 40; ++i) {
    loops.add(measuredEdge(truth, i, kLap + i, EdgeKind::kLoop, random), chain);
  }
  for (std::size_t i = 0; i < 80; ++i) {
    PoseEdge wrong = measuredEdge(truth, (7 * i) % kLap, kLap + (7 * i + 20 + i % 40) % kLap,
                                  EdgeKind::kLoop, random);
    wrong.measured = Pose2(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 0.0);
    loops.add(wrong, chain);
  }
  const Explanations found = loops.explain();
  EXPECT_TRUE(found.exact);
  EXPECT_GE(found.first.size(), 36U);
  EXPECT_LT(found.first.back(), 40U);
  EXPECT_LT(2 * found.second.size(), found.first.size());
}

TEST(ConsistentLoops, TwoExplanationsAreBothFound) {
  Random random(8);
  const std::vector<Pose2> truth = squareDrive(2);
  const OdometryChain chain(odometryGraph(truth, random));
  ConsistentLoops loops;
  for (std::size_t i = 0; i < 8; ++i) {
    loops.add(measuredEdge(truth, i, kLap + i, EdgeKind::kLoop, random), chain);
  }
  for (std::size_t i = 0; i < 7; ++i) {  // the same place, one door further
    loops.add(shifted(measuredEdge(truth, i, kLap + i, EdgeKind::kLoop, random), 3.0), chain);
  }
  const Explanations found = loops.explain();
  EXPECT_EQ(found.first, range(0, 8));
  EXPECT_GE(found.second.size(), 6U);  // one may miss the limit by chance
  EXPECT_GE(found.second.front(), 8U);
  const Explanations some = loops.explain({1, 9, 10, 11});
  EXPECT_EQ(some.first, range(9, 12));
  EXPECT_EQ(some.second, range(1, 2));
}

TEST(ConsistentLoops, LoopsOfUnconnectedPartsSayNothing) {
  Random random(9);
  const std::vector<Pose2> truth = squareDrive(2);
  PoseGraph graph = odometryGraph(truth, random);
  graph.edges.erase(graph.edges.begin() + kLap - 1);
  const OdometryChain chain(graph);
  ConsistentLoops loops;
  loops.add(measuredEdge(truth, 3, kLap + 3, EdgeKind::kLoop, random), chain);
  loops.add(measuredEdge(truth, kLap + 6, 6, EdgeKind::kLoop, random), chain);
  loops.add(measuredEdge(truth, 2, 30, EdgeKind::kLoop, random), chain);
  EXPECT_TRUE(loops.areConsistent(0, 1));
  EXPECT_FALSE(loops.areConsistent(0, 2));
  EXPECT_FALSE(checkCycle(measuredEdge(truth, 3, kLap + 3, EdgeKind::kLoop, random), chain));
}

TEST(ConsistentLoops, EmptyAndSingle) {
  Random random(10);
  const std::vector<Pose2> truth = squareDrive(1);
  const OdometryChain chain(odometryGraph(truth, random));
  ConsistentLoops loops;
  EXPECT_TRUE(loops.explain().first.empty());
  loops.add(measuredEdge(truth, 0, kLap, EdgeKind::kLoop, random), chain);
  EXPECT_EQ(loops.explain().first, range(0, 1));
  EXPECT_TRUE(loops.explain().second.empty());
}

}  // namespace
}  // namespace kestrel
