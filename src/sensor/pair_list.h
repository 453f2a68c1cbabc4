// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kestrel {

/// Reads "a:b, c:d" with any number of pairs, also none; nothing where the text is anything else.
std::optional<std::vector<std::pair<double, double>>> parsePairs(const std::string& text);

}  // namespace kestrel
