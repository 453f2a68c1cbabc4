// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace kestrel {

/// Splits a text with comma-separated names.
std::vector<std::string> splitNames(const std::string& text);

/// A name from a message, shortened to fit into one line.
std::string clippedName(const std::string& name);

}  // namespace kestrel
