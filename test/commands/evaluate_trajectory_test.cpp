// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "kestrel_slam/evaluation/scan_file.h"
#include "run_command.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

const std::string kEvaluate = KESTREL_TOOL_DIR "/evaluate_trajectory ";

/// Poses along x, ten per second, beginning at `first` (s).
std::string poses(int count, double first) {
  std::ostringstream text;
  for (int i = 0; i < count; ++i) {
    text << first + 0.1 * i << " " << 0.05 * i << " 0 0 0 0 0 1\n";
  }
  return text.str();
}

class EvaluateTrajectory : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string trajectory_ = folder_.write("trajectory.tum", poses(200, 0.0));
};

TEST_F(EvaluateTrajectory, WithoutAReferenceIsWrongUsage) {
  const Outcome outcome = runCommand(kEvaluate + trajectory_);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_CONTAINS(outcome.output, "--relations or --reference");
}

TEST_F(EvaluateTrajectory, AReferenceThatOverlapsIsCompared) {
  const std::string reference = folder_.write("reference.tum", poses(100, 0.0));
  EXPECT_EQ(runCommand(kEvaluate + trajectory_ + " --reference " + reference).code, 0);
}

TEST_F(EvaluateTrajectory, TheStatesOfTheScansAreCounted) {
  const std::string reference = folder_.write("reference.tum", poses(100, 0.0));
  ScanRow scan;
  std::vector<ScanRow> scans(20, scan);
  for (std::size_t i = 0; i < scans.size(); ++i) scans[i].stamp = 0.1 * static_cast<double>(i);
  const std::string states = folder_.write("scans.csv", scansText(scans));
  const Outcome outcome =
      runCommand(kEvaluate + trajectory_ + " --reference " + reference + " --scans " + states);
  EXPECT_EQ(outcome.code, 0);
  EXPECT_CONTAINS(outcome.output, "0 scans ok, 0 degraded, 20 lost; 0 ok, but wrong");
}

TEST_F(EvaluateTrajectory, OdometryShowsTheNoiseOfTheRelations) {
  std::ostringstream lines;
  for (int i = 0; i < 10; ++i) lines << i << " " << i + 1 << " 0.52 0 0 0 0 0\n";
  const std::string relations = folder_.write("relations", lines.str());
  const Outcome outcome = runCommand(kEvaluate + trajectory_ + " --relations " + relations +
                                     " --odometry " + trajectory_);
  EXPECT_EQ(outcome.code, 0);
  EXPECT_CONTAINS(outcome.output,
                  "noise of 10 relations up to 3 s: relations 0.0170 m, trajectory 0.0000 m");
}

TEST_F(EvaluateTrajectory, AReferenceThatHardlyOverlapsIsBadInput) {
  const std::string reference = folder_.write("reference.tum", poses(6, 0.0));
  const Outcome outcome = runCommand(kEvaluate + trajectory_ + " --reference " + reference);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_CONTAINS(outcome.output, "% of the poses have a reference near their stamp");
}

}  // namespace
}  // namespace kestrel
