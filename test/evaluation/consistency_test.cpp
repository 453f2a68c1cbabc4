// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/consistency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kestrel_slam/evaluation/covariance_file.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

TEST(Consistency, NeesOfIndependentAxes) {
  const Eigen::Matrix3d covariance = Eigen::Vector3d(4.0, 1.0, 0.25).asDiagonal();
  EXPECT_NEAR(neesOf({2.0, 3.0, 0.5}, covariance), 1.0 + 9.0 + 1.0, 1e-12);
}

TEST(Consistency, BandOfTheMean) {
  // Quantiles 2.5 % and 97.5 % of chi-square with 30 and with 300 degrees of freedom: 16.791,
  // 46.979 and 253.912, 349.874.
  EXPECT_NEAR(meanNeesBand(10).first, 1.6791, 0.002);
  EXPECT_NEAR(meanNeesBand(10).second, 4.6979, 0.002);
  EXPECT_NEAR(meanNeesBand(100).first, 2.53912, 0.001);
  EXPECT_NEAR(meanNeesBand(100).second, 3.49874, 0.001);
}

/// A run of one minute at 10 Hz. The poses have independent errors, whose standard deviation is
/// `actual` times the estimated one.
Consistency errsBy(double actual) {
  std::mt19937 generator(3);
  std::normal_distribution<double> noise(0.0, actual);
  const Eigen::Vector3d sigmas(0.01, 0.02, 0.005);
  std::vector<EvaluatedPose> poses;
  for (int i = 0; i <= 20000; ++i) {
    EvaluatedPose pose;
    pose.stamp = 0.1 * i;
    pose.truth = Pose2(0.05 * i, 0.0, 0.0);
    pose.estimate.pose = Pose2(0.05 * i + sigmas.x() * noise(generator),
                               sigmas.y() * noise(generator), sigmas.z() * noise(generator));
    pose.estimate.match_covariance = sigmas.cwiseAbs2().asDiagonal();
    poses.push_back(pose);
  }
  return consistencyOf(poses);
}

TEST(Consistency, CorrectCovariancesGiveTheExpectedNees) {
  const Consistency result = errsBy(1.0);
  ASSERT_EQ(result.absolute.size(), 2000U);
  EXPECT_NEAR(meanOf(result.absolute), 3.0, 0.2);
  EXPECT_NEAR(meanOf(result.relative), 3.0, 0.2);
  EXPECT_NEAR(shareWithin(result.absolute, kNeesBand), 0.95, 0.015);
  EXPECT_NEAR(shareWithin(result.relative, kNeesBand), 0.95, 0.015);
}

TEST(Consistency, ErrorsTwiceAsLargeGiveFourTimesTheNees) {
  const Consistency result = errsBy(2.0);
  EXPECT_NEAR(meanOf(result.absolute), 12.0, 0.8);
  EXPECT_LT(shareWithin(result.absolute, kNeesBand), 0.7);
}

TEST(CovarianceFile, RoundTripAndErrorsInSigmas) {
  const TemporaryFolder folder;
  ScanCovariance a, b;
  a.stamp = 10.0;
  b.stamp = 12.5;
  b.pose.pose = Pose2(1.3, 0.4, 0.02);
  b.pose.match_covariance = Eigen::Vector3d(0.0625, 0.0, 1e-4).asDiagonal();
  b.pose.match_covariance(1, 1) = 1e-8;
  a.pose.map_covariance = b.pose.map_covariance = 1e-3 * Eigen::Matrix3d::Ones();
  writeCovariances(folder.file("c.txt"), {a, b});
  const std::vector<ScanCovariance> read = readCovariances(folder.file("c.txt"));
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[1].stamp, 12.5);
  EXPECT_EQ(read[1].pose.pose, b.pose.pose);
  EXPECT_TRUE(read[1].pose.match_covariance.isApprox(b.pose.match_covariance, 1e-6));
  EXPECT_TRUE(read[1].pose.map_covariance.isApprox(b.pose.map_covariance, 1e-6));
  b.pose.map_covariance.setZero();
  a.pose.map_covariance.setZero();
  // An error of 0.5 m (0.3, 0.4) with a sigma of 0.25 m, and of 0.02 rad with a sigma of 0.01 rad.
  const CovarianceEvaluation result =
      evaluateCovariances({b, a}, {{10.0, 12.5, Pose2(1.0, 0.0, 0.0)}, {10.0, 99.0, Pose2()}});
  EXPECT_EQ(result.translation.count, 1U);
  EXPECT_NEAR(result.translation.mean, 2.0, 1e-4);
  EXPECT_NEAR(result.rotation.mean, 2.0, 1e-4);
}

TEST(CovarianceFile, ErrorNamesTheBrokenLine) {
  const TemporaryFolder folder;
  const std::string path = folder.write("c.txt", "# comment\n1 2 3\n");
  try {
    readCovariances(path);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("line 2"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace kestrel
