// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/commands/run_tool.h"

#include <cstdio>
#include <exception>

namespace kestrel {

int runTool(const std::string& name, CLI::App& app, int argc, char** argv, const Action& run,
            const Action& check) {
  try {
    app.parse(argc, argv);
    if (check) check();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kSuccess : kWrongUsage;
  }
  try {
    run();
  } catch (const std::exception& error) {
    std::fflush(stdout);
    std::fprintf(stderr, "%s: %s\n", name.c_str(), error.what());
    return kBadInput;
  }
  return kSuccess;
}

}  // namespace kestrel
