// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/recording/recording_info.h"

namespace kestrel {
namespace {

using Json = nlohmann::ordered_json;

void print(const std::string& path, const RecordingInfo& info) {
  std::printf("%s: %s", path.c_str(), info.format.empty() ? "no recording" : info.format.c_str());
  if (!info.topics.empty()) std::printf(", %.1f s", info.end - info.begin);
  std::printf("%s%s\n", info.problem.empty() ? "" : ": ", info.problem.c_str());
  for (const auto& [name, topic] : info.topics) {
    std::printf("  %-30s %8zu  %s\n", name.c_str(), topic.messages, topic.type.c_str());
  }
}

void printJson(const std::string& path, const RecordingInfo& info) {
  Json topics = Json::object();
  for (const auto& [name, topic] : info.topics) {
    topics[name] = {{"type", topic.type}, {"messages", topic.messages}};
  }
  const Json line = {{"path", path},          {"format", info.format}, {"problem", info.problem},
                     {"begin_s", info.begin}, {"end_s", info.end},     {"topics", topics}};
  std::puts(line.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app("Shows what files are: the format of a recording, the topics and times of a bag.");
  std::vector<std::string> files;
  bool json = false, quick = false;
  app.add_option("FILE", files, "files of any kind")->required();
  app.add_flag("--json", json, "print one line of JSON per file");
  app.add_flag("--quick", quick, "bags: read only the index at the end; does not find damage");
  return runTool("recording_info", app, argc, argv, [&] {
    for (const std::string& file : files) (json ? printJson : print)(file, infoOf(file, quick));
  });
}
