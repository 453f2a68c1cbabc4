// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace kestrel {

/// Exit codes of every tool.
constexpr int kSuccess = 0, kBadInput = 1, kWrongUsage = 2;

/// What a tool does once its command line is parsed.
using Action = std::function<void()>;

/// The frame of every tool: parses the command line into the options that were declared in `app`,
/// lets `check` look at them (it throws a CLI::ParseError for wrong usage), and does `run`. An
/// exception of `run` becomes one line that begins with `name`, and kBadInput. Returns the exit
/// code.
int runTool(const std::string& name, CLI::App& app, int argc, char** argv, const Action& run,
            const Action& check = {});

}  // namespace kestrel
