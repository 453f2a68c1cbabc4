// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/recording/trajectory.h"
#include "kestrel_slam/session/version.h"
#include "room_log_test.h"
#include "run_command.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

const std::string kCompare = KESTREL_TOOL_DIR "/compare_matchers ";

constexpr int kComparedScans = 25;

class CompareMatchersTest : public RoomLogTest {
 protected:
  CompareMatchersTest() : RoomLogTest(kComparedScans) {}

  Outcome compare(const std::string& arguments) {
    return runCommand(kCompare + log_ + " " + arguments);
  }
};

TEST_F(CompareMatchersTest, MapsWithEveryMatcher) {
  const Outcome outcome = compare(outputs("out"));
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_CONTAINS(outcome.output, "distance from hybrid, m (mean)");
  EXPECT_CONTAINS(outcome.output, "plot        " + folder_.file("out/comparison.png") + "\n");
  EXPECT_GT(fs::file_size(folder_.file("out/comparison.png")), 1000U);
  for (const std::string& method : matcherNames()) {
    EXPECT_CONTAINS(read("out/comparison.md"), "| " + method + " | 25 | 0 | ");
    const Trajectory trajectory = readTum(folder_.file("out/" + method + "/trajectory.tum"));
    ASSERT_EQ(trajectory.size(), 25U);
    EXPECT_NEAR(trajectory.back().pose.x, RoomFlight::x(kComparedScans - 1), 0.1) << method;
    EXPECT_TRUE(fs::exists(folder_.file("out/" + method + "/map.pgm"))) << method;
  }
}

TEST_F(CompareMatchersTest, PlotsTheLikelihoodOfAScan) {
  const Outcome outcome = compare("--surface 20" + outputs("out"));
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_CONTAINS(outcome.output, "plot        " + folder_.file("out/surface.png") + "\n");
  EXPECT_GT(fs::file_size(folder_.file("out/surface.png")), 1000U);
  const Outcome beyond = compare("--surface 99" + outputs("beyond"));
  EXPECT_EQ(beyond.code, 1);
  EXPECT_CONTAINS(beyond.output, "scan 99 cannot be shown: the run has 25 scans");
}

TEST_F(CompareMatchersTest, RelationsGiveTheError) {
  const std::string truth = "1000.0 1002.0 1.0 0 0 0 0 0\n";  // 20 steps of 0.05 m
  const std::string relations = folder_.write("truth.relations", truth);
  const Outcome outcome =
      compare("--quiet --no-timing --matchers hybrid,gauss_newton --relations " + relations +
              outputs("out"));
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_EQ(outcome.output, read("out/comparison.md"));
  EXPECT_CONTAINS(outcome.output, "error, m (mean)");
  EXPECT_EQ(outcome.output.find("correlative"), std::string::npos);
  const std::size_t row = outcome.output.find("| hybrid | 25 | 0 | ");
  ASSERT_NE(row, std::string::npos) << outcome.output;
  EXPECT_LT(std::stod(outcome.output.substr(row + 20)), 0.03);
}

TEST_F(CompareMatchersTest, MeasuresTheEvaluationFunction) {
  const Outcome outcome = compare("--evaluation --matchers gauss_newton" + outputs("out"));
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_CONTAINS(read("out/evaluation.md"), "| gauss_newton | ");
  EXPECT_GT(fs::file_size(folder_.file("out/evaluation.png")), 1000U);
}

TEST_F(CompareMatchersTest, BadInputIsOneLineAndExitCodeOne) {
  const std::string file = folder_.write("file", "");
  const std::string strange = folder_.write("strange.relations", "1 2 0 0 0 0 0 0\n");
  const struct {
    std::string arguments, words;
  } cases[] = {
      {folder_.file("missing.bag") + outputs("out"), "missing.bag"},
      {log_ + " --relations " + folder_.file("none") + outputs("out"), "none"},
      {log_ + " --quiet --matchers hybrid --relations " + strange + outputs("out"),
       "strange.relations: no relation has both stamps in the run; check that the relations "
       "belong"},
      {log_ + " --set map_resolution=-1" + outputs("out"), "map_resolution = -1: must be between"},
      {log_ + " --output " + file, "it is a file, not a folder"},
  };
  for (const auto& [arguments, words] : cases) {
    const Outcome outcome = runCommand(kCompare + arguments);
    EXPECT_EQ(outcome.code, 1) << arguments;
    EXPECT_EQ(outcome.output.rfind("compare_matchers: ", 0), 0U) << outcome.output;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
    EXPECT_CONTAINS(outcome.output, words);
  }
}

TEST_F(CompareMatchersTest, WrongUsageIsExitCodeTwo) {
  EXPECT_EQ(runCommand(kCompare).code, 2);
  EXPECT_EQ(compare("").code, 2);  // no --output
  EXPECT_EQ(compare("--matchers fast" + outputs("out")).code, 2);
  EXPECT_EQ(compare("--nonsense" + outputs("out")).code, 2);
}

TEST_F(CompareMatchersTest, HelpAndVersionNeedNoRecording) {
  EXPECT_EQ(runCommand(kCompare + "--help").code, 0);
  EXPECT_EQ(runCommand(kCompare + "--version").output, std::string(kVersion) + "\n");
}

}  // namespace
}  // namespace kestrel
