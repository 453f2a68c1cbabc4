// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace kestrel {
namespace {

std::string launchFile(const std::string& name) {
  std::ifstream file(KESTREL_SOURCE_DIR "/launch/" + name);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// The tags of the nodes that read private parameters of this package.
std::vector<std::string> nodeTags(const std::string& text) {
  std::vector<std::string> tags;
  for (std::size_t at = text.find("<node "); at != std::string::npos;
       at = text.find("<node ", at + 1)) {
    const std::string tag = text.substr(at, text.find('>', at) - at);
    const bool is_ours = tag.find("pkg=\"kestrel_slam\"") != std::string::npos ||
                         tag.find("pkg=\"$(arg package)\"") != std::string::npos;
    if (is_ours) tags.push_back(tag);
  }
  return tags;
}

/// On the same master, mapper.launch after mav.launch must not keep input = planar_scan.
TEST(LaunchFiles, NothingRemainsOfAnEarlierStart) {
  for (const char* name : {"mapper.launch", "mav.launch", "replay.launch", "demo.launch"}) {
    const std::vector<std::string> tags = nodeTags(launchFile(name));
    EXPECT_FALSE(tags.empty()) << name;
    for (const std::string& tag : tags) {
      EXPECT_NE(tag.find("clear_params=\"true\""), std::string::npos) << name << ": " << tag;
    }
  }
}

TEST(LaunchFiles, ThePathOfABagMayHaveBlanks) {
  EXPECT_NE(launchFile("replay.launch").find("&quot;$(arg bag)&quot;"), std::string::npos);
}

}  // namespace
}  // namespace kestrel
