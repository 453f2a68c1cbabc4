// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/keyframe_errors.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "graph/graph_samples.h"
#include "kestrel_slam/graph/optimizer.h"

namespace kestrel {
namespace {

/// Keyframes of a drive with errors as those of a mapper: small ones that last, and those of the
/// matches.
struct MappedDrive {
  PoseGraph graph;
  std::vector<KeyframeErrors> errors;
  std::vector<Pose2> matches;  ///< their errors

  MappedDrive(const std::vector<Pose2>& truth, Random& random) {
    const Eigen::Matrix3d lasting = informationOf(0.002, 0.0002),
                          match = informationOf(0.01, 0.003);
    Pose2 local, before;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (i > 0) local = local * truth[i - 1].between(truth[i]) * noise(random, lasting);
      matches.push_back(i > 0 ? noise(random, match) : Pose2());
      const Pose2 found = local * matches.back();
      graph.vertices.push_back({found});
      errors.emplace_back();
      if (i > 0) {
        errors.back() = {lasting.inverse(), match.inverse()};
        const Eigen::Matrix3d of_edge = lasting.inverse() + 2.0 * Eigen::Matrix3d(match.inverse());
        graph.edges.push_back(
            {i - 1, i, before.between(found), of_edge.inverse(), EdgeKind::kOdometry});
      }
      before = found;
    }
  }

  void addLoop(const std::vector<Pose2>& truth, std::size_t from, std::size_t to, Random& random) {
    const Eigen::Matrix3d loop = informationOf(0.02, 0.004);
    const Pose2 motion = (truth[from] * matches[from]).between(truth[to] * matches[to]);
    graph.edges.push_back({from, to, motion * noise(random, loop), loop, EdgeKind::kLoop});
  }

  static Eigen::Matrix3d informationOf(double sigma_m, double sigma_rad) {
    return Eigen::Vector3d(sigma_m, sigma_m, sigma_rad).cwiseAbs2().cwiseInverse().asDiagonal();
  }
};

double squared(const Pose2& error, const Eigen::Matrix3d& covariance) {
  return error.log().dot(covariance.inverse() * error.log());
}

/// Mean squared errors of keyframe `at` by the covariances of the keyframes, and by those of the
/// edges; with a loop from each of the last `loops` keyframes to the lap before.
std::pair<double, double> meanNees(std::size_t loops, std::size_t at) {
  constexpr int kRuns = 60;
  const std::vector<Pose2> truth = squareDrive(2);
  Random random(4);
  double by_keyframes = 0.0, by_edges = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    MappedDrive drive(truth, random);
    for (std::size_t i = truth.size() - loops; i < truth.size(); ++i)
      drive.addLoop(truth, i - kLap, i, random);
    optimize(drive.graph, {0.0});
    const auto pose = KeyframeMarginals(drive.graph, drive.errors, {}).between(0, at);
    const auto of_edges = GraphMarginals(drive.graph, {}).between(0, at);
    const Pose2 error = pose->mean.between(truth[0].between(truth[at]));
    by_keyframes += squared(error, pose->covariance + drive.errors[at].match) / kRuns;
    by_edges += squared(error, of_edges->covariance) / kRuns;
  }
  return {by_keyframes, by_edges};
}

const double kBand = 4.0 * std::sqrt(6.0 / 60.0);  // four standard deviations of the mean

TEST(KeyframeMarginals, DescribeTheErrorsOfAChain) {
  const auto [by_keyframes, by_edges] = meanNees(0, 150);
  EXPECT_NEAR(by_keyframes, 3.0, kBand);
  EXPECT_LT(by_edges, 0.5) << "the errors of the matches cancel";
}

TEST(KeyframeMarginals, DescribeTheErrorsAfterLoops) {
  for (const std::size_t loops : {1, 20}) {
    const auto [by_keyframes, by_edges] = meanNees(loops, 150);
    EXPECT_NEAR(by_keyframes, 3.0, kBand) << loops;
    EXPECT_LT(by_edges, 1.0) << loops;
  }
}

TEST(KeyframeMarginals, HaveTheErrorOfTheFirstKeyframe) {
  Random random(5);
  MappedDrive drive(squareDrive(1), random);
  const auto without = KeyframeMarginals(drive.graph, drive.errors, {}).between(0, 40);
  drive.errors[0].lasting(2, 2) = 1e-4;
  const auto with = KeyframeMarginals(drive.graph, drive.errors, {}).between(0, 40);
  const double lever2 = with->mean.translation().squaredNorm();
  const Eigen::Matrix3d added = with->covariance - without->covariance;
  EXPECT_NEAR(added(0, 0) + added(1, 1), 1e-4 * lever2, 1e-9);
  EXPECT_EQ(with->mean, without->mean);
}

TEST(KeyframeMarginals, KnowNothingBetweenPartsThatAreNotJoined) {
  Random random(6);
  MappedDrive drive(squareDrive(1), random);
  drive.graph.edges.erase(drive.graph.edges.begin() + 30);
  EXPECT_TRUE(KeyframeMarginals(drive.graph, drive.errors, {}).between(0, 20));
  EXPECT_FALSE(KeyframeMarginals(drive.graph, drive.errors, {}).between(0, 40));
}

/// In a known room the map does not grow, so its errors are nothing.
TEST(KeyframeMarginals, AnErrorMayBeZero) {
  Random random(7);
  MappedDrive drive(squareDrive(1), random);
  for (KeyframeErrors& errors : drive.errors) errors.lasting.setZero();
  const auto pose = KeyframeMarginals(drive.graph, drive.errors, {}).between(0, 5);
  ASSERT_TRUE(pose);
  EXPECT_LT(std::sqrt(pose->covariance(0, 0)), 1e-3);
}

}  // namespace
}  // namespace kestrel
