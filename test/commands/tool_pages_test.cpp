// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "kestrel_slam/map/atomic_file.h"
#include "run_command.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

const std::string kTool = KESTREL_TOOL_DIR "/map_recording";
const std::string kMerger = KESTREL_SOURCE_DIR "/scripts/map_merger";
const std::string kMapBatch = KESTREL_SOURCE_DIR "/scripts/map_batch";

/// What bash offers at the end of `line`.
std::string completionsOf(const std::string& tool, const std::string& words, int index) {
  const TemporaryFolder folder;
  const std::string file =
      folder.write("completion", runCommand(tool + " --bash-completion").output);
  const std::string name = std::filesystem::path(tool).filename().string();
  return runCommand("bash -c 'compopt() { :; }; source " + file + "; COMP_WORDS=(" + words +
                    "); COMP_CWORD=" + std::to_string(index) + "; _kestrel_slam_" + name + " " +
                    tool + "; echo ${COMPREPLY[*]}'")
      .output;
}

TEST(ToolPagesTest, BashCompletesOptionsValuesAndParameters) {
  EXPECT_EQ(completionsOf(kTool, "map_recording --skip", 1), "--skip-scans\n");
  EXPECT_EQ(completionsOf(kTool, "map_recording --odometry \"\"", 2), "none use\n");
  EXPECT_EQ(completionsOf(kTool, "map_recording --set map_resol", 2), "map_resolution=\n");
  EXPECT_EQ(completionsOf(kMapBatch, "map_batch --max-r", 1), "--max-relations\n");
  EXPECT_EQ(completionsOf(kMapBatch, "map_batch --loops \"\"", 2), "none use\n");
  setenv("KESTREL_TOOLS", KESTREL_TOOL_DIR, 1);
  EXPECT_EQ(completionsOf(kMapBatch, "map_batch --set map_resol", 2), "map_resolution=\n");
  EXPECT_EQ(completionsOf(kMerger, "map_merger _ses", 1), "_sessions:=\n");
}

TEST(ToolPagesTest, ANodeHasAManPageOfItsParameters) {
  const std::string page = runCommand(kMerger + " --man-page").output;
  EXPECT_EQ(page.rfind(".TH MAP_MERGER", 0), 0U) << page;
  EXPECT_CONTAINS(page, "_sessions:=VALUE");
}

TEST(ToolPagesTest, ManPagesListEveryOption) {
  for (const std::string& tool : {kTool, kMapBatch}) {
    const std::string page = runCommand(tool + " --man-page").output;
    EXPECT_EQ(page.rfind(".TH MAP_", 0), 0U) << page;
    EXPECT_CONTAINS(page, ".SH OPTIONS");
    EXPECT_CONTAINS(page, "\\-\\-output");
    EXPECT_CONTAINS(page, "\\-\\-scan\\-topic");
  }
  EXPECT_CONTAINS(runCommand(kMapBatch + " --man-page").output, "summary.json)\n.SH SYNOPSIS");
}

}  // namespace
}  // namespace kestrel
