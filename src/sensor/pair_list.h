// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kestrel {

/// Parses "a:b, c:d" with any number of pairs. An empty text gives an empty list, an invalid text
/// nothing.
std::optional<std::vector<std::pair<double, double>>> parsePairs(const std::string& text);

}  // namespace kestrel
