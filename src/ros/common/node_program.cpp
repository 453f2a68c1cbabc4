// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_program.h"

#include "kestrel_slam/parameters/parameters_text.h"

namespace kestrel {
namespace {

std::string helpOf(const NodeProgram& program, const std::vector<Parameter>& table) {
  const std::string name = program.program;
  return name + ": " + program.purpose +
         "\n\n"
         "Usage:\n"
         "  " +
         program.launch +
         "\n"
         "  rosrun kestrel_slam " +
         name +
         " [_PARAMETER:=VALUE ...] [TOPIC:=OTHER_TOPIC ...]\n"
         "  rosrun kestrel_slam " +
         name +
         " --help                 print this text\n"
         "  rosrun kestrel_slam " +
         name +
         " --parameters-markdown  print the parameters as Markdown tables\n\n"
         "Topics, services and tf: doc/ros_api.md.\n\n"
         "Parameters, in the private namespace of the node, with default, limits and effect:\n\n" +
         parametersHelp(table);
}

}  // namespace

std::optional<std::string> answerTo(const std::vector<std::string>& arguments,
                                    const NodeProgram& program,
                                    const std::vector<Parameter>& table) {
  for (const std::string& argument : arguments) {
    if (argument == "--help" || argument == "-h") return helpOf(program, table);
    if (argument == "--parameters-markdown") return parametersMarkdown(table);
  }
  return std::nullopt;
}

std::string unusedArguments(int argc, char** argv) {
  constexpr std::size_t kMost = 60;
  std::string list;
  for (int i = 1; i < argc; ++i) list += (list.empty() ? "" : " ") + std::string(argv[i]);
  if (list.empty()) return "";
  if (list.size() > kMost) list = list.substr(0, kMost) + "...";
  const bool is_lua = list.find("-configuration_") != std::string::npos;
  return "The arguments " + list + " have no effect: " +
         (is_lua ? "Lua files are not read. doc/migration.md has the parameters to set instead."
                 : "set parameters as _name:=value, see --help.");
}

}  // namespace kestrel
