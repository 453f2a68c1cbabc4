// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/evaluation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/recording/text_stream.h"
#include "kestrel_slam/report/evaluation_plot.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

TEST(Statistics, UsePopulationStandardDeviation) {
  const ErrorStatistics s = statisticsOf({4.0, 1.0, 2.0, 5.0});
  EXPECT_EQ(s.count, 4U);
  EXPECT_DOUBLE_EQ(s.mean, 3.0);
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(2.5));
  EXPECT_DOUBLE_EQ(s.median, 3.0);
  EXPECT_DOUBLE_EQ(s.max, 5.0);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(11.5));
  EXPECT_DOUBLE_EQ(statisticsOf({7.0, 1.0, 2.0}).median, 2.0);
  EXPECT_EQ(statisticsOf(std::vector<double>()).count, 0U);
}

TEST(Relations, ErrorIsTheDifferenceOfTheRelativePoses) {
  // Pose 2 in the frame of pose 1 is 2 m ahead and rotated left; in the relation it is 2 m ahead
  // and 1 m to the left.
  const Trajectory trajectory = {{10.0, Pose2(5.0, 5.0, kPi / 2.0)}, {100.0, Pose2(5.0, 7.0, kPi)}};
  const RelationEvaluation result =
      evaluateRelations(trajectory, {{10.0, 100.0, Pose2(2.0, 1.0, kPi / 2.0 - degToRad(3.0))}});
  ASSERT_EQ(result.errors.size(), 1U);
  EXPECT_EQ(result.errors[0].stamp, 10.0);
  EXPECT_NEAR(result.errors[0].translation_m, 1.0, 1e-12);
  EXPECT_NEAR(result.errors[0].rotation_deg, 3.0, 1e-9);
  EXPECT_TRUE(result.unmatched.empty());
}

TEST(Relations, SeparatesRelationsOverMoreThanAMinute) {
  const Trajectory trajectory = {
      {0.0, Pose2()}, {60.0, Pose2(1.0, 0.0, 0.0)}, {60.1, Pose2(2.0, 0.0, 0.0)}};
  const RelationEvaluation result = evaluateRelations(
      trajectory, {{0.0, 60.0, Pose2()}, {0.0, 60.1, Pose2()}, {60.1, 0.0, Pose2()}});
  EXPECT_EQ(result.all.translation_m.count, 3U);
  EXPECT_DOUBLE_EQ(result.all.translation_m.mean, 5.0 / 3.0);
  EXPECT_EQ(result.distant.translation_m.count, 2U);
  EXPECT_DOUBLE_EQ(result.distant.translation_m.mean, 2.0);
}

TEST(Relations, FindsStampsInAnUnsortedTrajectory) {
  const Trajectory trajectory = {{976052857.9, Pose2(9.0, 0.0, 0.0)},
                                 {976052857.6, Pose2(0.0, 0.0, 0.0)},
                                 {976052857.60005, Pose2(8.0, 0.0, 0.0)},
                                 {976052857.7, Pose2(1.0, 0.0, 0.0)}};
  const RelationEvaluation result =
      evaluateRelations(trajectory, {{976052857.600004, 976052857.7, Pose2(1.0, 0.0, 0.0)}});
  ASSERT_EQ(result.errors.size(), 1U);
  EXPECT_NEAR(result.errors[0].translation_m, 0.0, 1e-12);
}

TEST(Relations, ReportsStampsMissingInTheTrajectory) {
  const Trajectory trajectory = {{1.0, Pose2()}, {2.0, Pose2()}};
  const RelationEvaluation result = evaluateRelations(
      trajectory,
      {{1.0, 2.0, Pose2()}, {3.0, 1.0, Pose2()}, {1.0, 2.00002, Pose2()}, {3.0, 2.0, Pose2()}});
  EXPECT_EQ(result.errors.size(), 1U);
  EXPECT_EQ(result.skipped_relations, 3U);
  EXPECT_EQ(result.unmatched, (std::vector<double>{2.00002, 3.0}));
}

TEST(Relations, ErrorsDescribeTheProblem) {
  const TemporaryFolder folder;
  const auto problem = [&](const std::string& content) {
    const std::string path = folder.write("r.relations", content);
    return messageOf([&] { readRelations(path); });
  };
  EXPECT_CONTAINS(problem("1 2 0 0 0 0 0 0\n1 2 3\n"), "r.relations, line 2: expected 8 fields");
  EXPECT_CONTAINS(problem("1 2 0 0 0 0 0 inf\n"), "line 1: 'inf' is not a finite number");
  EXPECT_CONTAINS(problem(""), "has no relations");
}

Trajectory transformed(const Trajectory& trajectory, const Pose2& by) {
  Trajectory result;
  for (const StampedPose& entry : trajectory) result.push_back({entry.stamp, by * entry.pose});
  return result;
}

/// A motion along x, then along y, with 0.5 m/s and ten poses per second.
Trajectory bentPath() {
  Trajectory path;
  for (int i = 0; i < 100; ++i) {
    path.push_back({i / 10.0, Pose2(0.05 * std::min(i, 50), 0.05 * std::max(0, i - 50),
                                    i < 50 ? 0.0 : kPi / 2.0)});
  }
  return path;
}

TEST(Relations, ThreeMeasurementsShowTheNoiseOfEach) {
  Random random(1);
  const auto noisy = [&](double sigma) {
    return Pose2(0.4 + sigma * random.gaussian(), sigma * random.gaussian(), 0.0);
  };
  Trajectory mapped = {{0.0, Pose2()}}, wheels = mapped;
  std::vector<Relation> relations;
  for (int i = 0; i < 1000; ++i) {
    const double stamp = mapped.back().stamp;
    mapped.push_back({stamp + 1.0, mapped.back().pose * noisy(0.002)});
    wheels.push_back({stamp + 1.0, wheels.back().pose * noisy(0.03)});
    relations.push_back({stamp, stamp + 1.0, noisy(0.02)});
  }
  relations.push_back({0.0, 900.0, Pose2(50.0, 0.0, 0.0)});  // too long: the odometry drifts
  const RelationNoise noise = noiseOf(relations, mapped, wheels);
  EXPECT_EQ(noise.count, 1000U);
  EXPECT_NEAR(noise.relations_m, 0.02, 0.003);
  EXPECT_LT(noise.trajectory_m, 0.008);
  EXPECT_NEAR(noise.odometry_m, 0.03, 0.003);
}

TEST(Relations, WhereTheVehicleStandsNothingIsCompared) {
  const Trajectory standing = {{0.0, Pose2()}, {1.0, Pose2(0.01, 0.0, 0.0)}};
  const RelationNoise noise = noiseOf({{0.0, 1.0, Pose2(0.5, 0.0, 0.0)}}, standing, standing);
  EXPECT_EQ(noise.count, 0U);
  EXPECT_EQ(noise.relations_m, 0.0);
}

TEST(Reference, AlignmentRemovesARigidMotion) {
  const Pose2 motion(3.0, -1.0, 2.0);
  const Trajectory reference = transformed(bentPath(), motion);
  const ReferenceEvaluation result = evaluateReference(bentPath(), reference);
  EXPECT_NEAR(result.reference_T_map.x, motion.x, 1e-9);
  EXPECT_NEAR(result.reference_T_map.y, motion.y, 1e-9);
  EXPECT_NEAR(result.reference_T_map.yaw, motion.yaw, 1e-9);
  EXPECT_NEAR(result.ate_statistics.translation_m.max, 0.0, 1e-9);
  EXPECT_NEAR(result.ate_statistics.rotation_deg.max, 0.0, 1e-6);
  EXPECT_NEAR(result.rpe_per_meter.translation_m.max, 0.0, 1e-9);
}

TEST(Reference, AteOfFourPosesMatchesAManualCalculation) {
  // The estimate is 10 % too long. The best alignment makes the centers equal.
  const Trajectory reference = {
      {0.0, Pose2(0, 0, 0)}, {1.0, Pose2(1, 0, 0)}, {2.0, Pose2(2, 0, 0)}, {3.0, Pose2(3, 0, 0)}};
  Trajectory estimate = reference;
  for (StampedPose& entry : estimate) entry.pose.x *= 1.1;
  const ReferenceEvaluation result = evaluateReference(estimate, reference);
  EXPECT_NEAR(result.reference_T_map.x, -0.15, 1e-12);
  EXPECT_NEAR(result.ate_statistics.translation_m.max, 0.15, 1e-12);
  EXPECT_NEAR(result.ate_statistics.translation_m.mean, 0.10, 1e-12);
  EXPECT_NEAR(result.ate_statistics.translation_m.rmse, std::sqrt(0.0125), 1e-12);
  EXPECT_EQ(result.rpe_per_meter.translation_m.count, 3U);
  EXPECT_NEAR(result.rpe_per_meter.translation_m.mean, 0.1, 1e-12);
  EXPECT_NEAR(result.rpe_per_second.translation_m.mean, 0.1, 1e-12);
}

TEST(Reference, InterpolatesAcrossTheYawWrap) {
  const Trajectory reference = {{0.0, Pose2(0.0, 0.0, kPi - 0.1)},
                                {0.4, Pose2(4.0, 0.0, 0.1 - kPi)}};
  const Trajectory estimate = {{0.0, Pose2(0.0, 0.0, kPi - 0.1)},
                               {0.2, Pose2(2.0, 0.0, kPi)},
                               {0.4, Pose2(4.0, 0.0, 0.1 - kPi)},
                               {0.5, Pose2()}};
  const ReferenceEvaluation result = evaluateReference(estimate, reference);
  EXPECT_EQ(result.unmatched, 1U);
  EXPECT_NEAR(result.ate_statistics.translation_m.max, 0.0, 1e-9);
  EXPECT_NEAR(result.ate_statistics.rotation_deg.max, 0.0, 1e-6);
}

TEST(Reference, DifferentClocksAreAnError) {
  EXPECT_CONTAINS(messageOf([] {
                    evaluateReference(bentPath(), {{1e9, Pose2()}, {1e9 + 0.1, Pose2()}});
                  }),
                  "same clock");
}

TEST(EvaluationPlot, WritesAPngAndAnSvgForASinglePose) {
  const TemporaryFolder folder;
  const std::string path = folder.file("p.png");
  plotEvaluation(path, "a.tum", {{1.0, Pose2()}}, RelationEvaluation(), std::nullopt);
  EXPECT_EQ(readMagic(path, 4), "\x89PNG");
  EXPECT_EQ(readMagic(folder.file("p.svg"), 5), "<?xml");
  EXPECT_CONTAINS(messageOf([&] { plotEvaluation(folder.file("no/p.png"), "", {}, {}, {}); }),
                  "no/p.png: No such file");
}

}  // namespace
}  // namespace kestrel
