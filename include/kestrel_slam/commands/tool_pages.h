// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace kestrel {

/// The man page of a tool, made from its options.
std::string manPage(const std::string& name, const CLI::App& app);

/// The completion for bash of a tool, made from its options: names of options, values with a fixed
/// choice, and after --set the names of the parameters.
std::string bashCompletion(const std::string& name, const CLI::App& app);

}  // namespace kestrel
