// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/matcher_comparison.h"

#include <gtest/gtest.h>

#include "kestrel_slam/geometry/angles.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// A run with scans at 0, 1, 2, ... s and `step` m between them along x; the last one is `off` m to
/// the side.
MethodRun runOf(const std::string& method, double step, double off) {
  MethodRun result{method, {}};
  for (int i = 0; i < 4; ++i) {
    result.run.trajectory.push_back({1.0 * i, Pose2(step * i, i == 3 ? off : 0.0, 0.0)});
    ScanRecord scan;
    scan.state = i == 2 && off > 0.0 ? MatchState::kLost : MatchState::kOk;
    scan.iterations = 2 * i;
    scan.searched = i == 3;
    scan.ms = 0.5;
    result.run.scans.push_back(scan);
  }
  return result;
}

TEST(MatcherComparisonTest, WithoutRelationsRunsAreComparedWithTheReference) {
  const std::vector<MethodRun> runs = {runOf("icp", 1.1, 0.4), runOf("hybrid", 1.0, 0.0)};
  const MatcherComparison comparison = compareRuns(runs, std::nullopt, "hybrid");
  EXPECT_EQ(comparison.reference, "hybrid");
  ASSERT_EQ(comparison.errors.size(), 1U);
  EXPECT_EQ(comparison.errors[0].method, "icp");
  const ErrorStatistics& distance = comparison.errors[0].statistics.translation_m;
  EXPECT_EQ(distance.count, 4U);
  EXPECT_NEAR(distance.mean, (0.0 + 0.1 + 0.2 + 0.5) / 4.0, 1e-9);
  EXPECT_NEAR(distance.max, 0.5, 1e-9);
  EXPECT_EQ(compareRuns({runs[0]}, std::nullopt, "hybrid").reference, "icp");
}

TEST(MatcherComparisonTest, RelationErrorsHaveTheLaterStamp) {
  const std::vector<MethodRun> runs = {runOf("icp", 1.1, 0.0), runOf("hybrid", 1.0, 0.0)};
  const std::vector<Relation> relations = {{2.0, 0.0, Pose2(-2.0, 0.0, degToRad(1.0))},
                                           {1.0, 77.0, Pose2()}};
  const MatcherComparison comparison = compareRuns(runs, relations, "hybrid");
  EXPECT_EQ(comparison.reference, "");
  ASSERT_EQ(comparison.errors.size(), 2U);
  ASSERT_EQ(comparison.errors[0].errors.size(), 1U);  // there is no scan at 77 s
  EXPECT_EQ(comparison.errors[0].errors[0].stamp, 2.0);
  EXPECT_NEAR(comparison.errors[0].errors[0].translation_m, 0.2, 1e-9);
  EXPECT_NEAR(comparison.errors[0].errors[0].rotation_deg, 1.0, 1e-9);
  EXPECT_NEAR(comparison.errors[1].errors[0].translation_m, 0.0, 1e-9);
}

TEST(MatcherComparisonTest, RelationsOfAnotherRecordingAreRejected) {
  EXPECT_CONTAINS(messageOf([] {
                    compareRuns({runOf("icp", 1.0, 0.0)}, {{{50.0, 51.0, Pose2()}}}, "hybrid");
                  }),
                  "no relation has both stamps");
}

TEST(MatcherComparisonTest, TableHasARowForEachMethod) {
  const std::vector<MethodRun> runs = {runOf("icp", 1.1, 0.4), runOf("hybrid", 1.0, 0.0)};
  const MatcherComparison comparison = compareRuns(runs, std::nullopt, "hybrid");
  const std::string table = comparisonTable(runs, comparison, true);
  EXPECT_CONTAINS(table, "distance from hybrid, m (mean)");
  EXPECT_CONTAINS(table, "| icp | 4 | 1 | 0.2000 | 0.50 | 0.000 | 0.0 | 3.0 | 1 | 0.50 | 0.50 |\n");
  EXPECT_CONTAINS(table, "| hybrid | 4 | 0 |  |  |  |  | 3.0 | 1 | 0.50 | 0.50 |\n");
  EXPECT_EQ(comparisonTable(runs, comparison, false).find("ms"), std::string::npos);
}

TEST(MatcherComparisonTest, WritesThePlot) {
  const std::vector<MethodRun> runs = {runOf("icp", 1.1, 0.4), runOf("hybrid", 1.0, 0.0)};
  TemporaryFolder folder;
  plotComparison(folder.file("c.png"), runs, compareRuns(runs, std::nullopt, "hybrid"));
  EXPECT_GT(std::filesystem::file_size(folder.file("c.png")), 1000U);
}

}  // namespace
}  // namespace kestrel
