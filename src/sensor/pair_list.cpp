// SPDX-License-Identifier: BSD-3-Clause
#include "pair_list.h"

#include <locale>
#include <sstream>

namespace kestrel {

std::optional<std::vector<std::pair<double, double>>> parsePairs(const std::string& text) {
  std::vector<std::pair<double, double>> pairs;
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ',');) {
    std::istringstream stream(item);
    stream.imbue(std::locale::classic());
    double first = 0.0, second = 0.0;
    char colon = 0;
    if (!(stream >> first >> colon >> second) || colon != ':') return std::nullopt;
    if (!(stream >> std::ws).eof()) return std::nullopt;
    pairs.emplace_back(first, second);
  }
  return pairs;
}

}  // namespace kestrel
