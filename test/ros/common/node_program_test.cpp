// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_program.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/parameters/parameters_text.h"
#include "run_command.h"

namespace kestrel {
namespace {

const std::vector<std::string> kPrograms = {"mapper_node", "scan_projector_node",
                                            "pose_filter_node"};

/// Runs the program of a node without a ROS master.
Outcome run(const std::string& program, const std::string& argument) {
  return runCommand("env ROS_MASTER_URI=http://127.0.0.1:1 timeout 20 " KESTREL_TOOL_DIR "/" +
                    program + " " + argument);
}

/// The lines between the markers of a program in doc/ros_api.md, without the empty lines around
/// them; "" without markers.
std::string documented(const std::string& program) {
  const std::string text = readFile(KESTREL_SOURCE_DIR "/doc/ros_api.md");
  const std::string begin = "<!-- parameters: " + program + " -->\n";
  const std::size_t marker = text.find(begin);
  if (marker == std::string::npos) return "";
  const std::size_t first = text.find_first_not_of('\n', marker + begin.size());
  const std::size_t end = text.find("<!-- end -->", marker);
  if (end == std::string::npos || end <= first) return "";
  return text.substr(first, text.find_last_not_of('\n', end - 1) + 2 - first);
}

TEST(NodeProgram, ParametersEqualTheDocument) {
  for (const std::string& program : kPrograms) {
    const Outcome outcome = run(program, "--parameters-markdown");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_NE(outcome.output.find("| `base_frame` | `base_link` |"), std::string::npos);
    EXPECT_TRUE(documented(program) == outcome.output)
        << "The parameters of " << program << " in doc/ros_api.md differ from the code.\n"
        << "Run scripts/update_api_doc, which updates them.";
  }
}

TEST(NodeProgram, ParametersOfOtherProgramsEqualTheDocument) {
  for (const std::string program : {"geotiff_node", "map_to_image_node", "simulated_flight"}) {
    EXPECT_TRUE(documented(program) == run(program, "--parameters-markdown").output)
        << program << ": run scripts/update_api_doc";
  }
}

TEST(NodeProgram, HelpNeedsNoMaster) {
  for (const std::string& program : kPrograms) {
    const Outcome outcome = run(program, "--help");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.output.rfind(program + ": ", 0), 0U) << outcome.output;
    EXPECT_NE(outcome.output.find("\n  base_frame: base_link\n"), std::string::npos) << program;
  }
}

TEST(NodeProgram, AnswersOnlyItsOwnOptions) {
  const NodeProgram program = {"mapper", "mapper_node", "builds a map.", "roslaunch x y"};
  SlamConfig defaults;
  const std::vector<Parameter> table = parametersOf(defaults);
  EXPECT_FALSE(answerTo({}, program, table));
  EXPECT_FALSE(answerTo({"__name:=mapper", "_map_resolution:=0.1"}, program, table));
  EXPECT_EQ(answerTo({"--parameters-markdown"}, program, table), parametersMarkdown(table));
  const std::string help = answerTo({"__name:=mapper", "-h"}, program, table).value();
  EXPECT_EQ(help.rfind("mapper_node: builds a map.\n", 0), 0U) << help;
  EXPECT_NE(help.find("  roslaunch x y\n"), std::string::npos) << help;
  EXPECT_NE(help.find("  map_resolution: 0.05 m (0.005 to 1 m)\n"), std::string::npos) << help;
}

}  // namespace
}  // namespace kestrel
