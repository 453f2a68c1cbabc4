// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace kestrel {

/// Exit codes of every tool.
constexpr int kSuccess = 0, kBadInput = 1, kWrongUsage = 2, kLimitMissed = 3;

/// A function that runs after the command line is parsed.
using Action = std::function<void()>;

/// The main function of every tool. Parses the command line into the options of `app`, calls
/// `check` (which throws a CLI::ParseError for wrong usage), then calls `run`. If `run` throws,
/// prints one line that begins with `name` and returns kBadInput. Returns the exit code.
int runTool(const std::string& name, CLI::App& app, int argc, char** argv, const Action& run,
            const Action& check = {});

}  // namespace kestrel
