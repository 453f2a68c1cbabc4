// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "run_command.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

const std::string kTool = KESTREL_TOOL_DIR "/evaluate_trajectory ";

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
  const Outcome outcome = runCommand(kTool + trajectory_);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_CONTAINS(outcome.output, "--relations or --reference");
}

TEST_F(EvaluateTrajectory, AReferenceThatOverlapsIsCompared) {
  const std::string reference = folder_.write("reference.tum", poses(100, 0.0));
  EXPECT_EQ(runCommand(kTool + trajectory_ + " --reference " + reference).code, 0);
}

TEST_F(EvaluateTrajectory, AReferenceThatHardlyOverlapsIsBadInput) {
  const std::string reference = folder_.write("reference.tum", poses(6, 0.0));
  const Outcome outcome = runCommand(kTool + trajectory_ + " --reference " + reference);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_CONTAINS(outcome.output, "% of the poses have a reference near their stamp");
}

}  // namespace
}  // namespace kestrel
