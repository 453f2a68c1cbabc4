// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/names.h"

#include <algorithm>
#include <sstream>

namespace kestrel {

std::vector<std::string> splitNames(const std::string& text) {
  std::string spaced = text;
  std::replace(spaced.begin(), spaced.end(), ',', ' ');
  std::istringstream stream(spaced);
  std::vector<std::string> names;
  for (std::string name; stream >> name;) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

std::string clippedName(const std::string& name) {
  constexpr std::size_t kMaxLength = 40;
  return name.size() <= kMaxLength ? name : name.substr(0, kMaxLength) + "...";
}

}  // namespace kestrel
