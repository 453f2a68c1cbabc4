// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// The parameters with default, unit, limits and effect for a terminal, under their headings. The
/// places must hold the defaults.
std::string parametersHelp(const std::vector<Parameter>& table);

/// The same as Markdown: one table for each heading.
std::string parametersMarkdown(const std::vector<Parameter>& table);

}  // namespace kestrel
