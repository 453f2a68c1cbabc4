// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/commands/run_tool.h"

#include <cstdio>
#include <exception>
#include <memory>
#include <sstream>

#include "kestrel_slam/commands/tool_pages.h"

namespace kestrel {
namespace {

constexpr std::size_t kHelpWidth = 80, kHelpIndent = 30;  // characters

/// Writes the description of an option in lines of 80 characters, beside or below its name.
class WrappedHelp : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    std::string line = "  " + make_option_name(option, is_positional) + make_option_opts(option);
    std::string help;
    if (line.size() + 2 > kHelpIndent) {
      help = line + "\n";
      line.clear();
    }
    line.resize(kHelpIndent, ' ');
    std::istringstream words(make_option_desc(option));
    for (std::string word; words >> word;) {
      if (line.size() > kHelpIndent && line.size() + 1 + word.size() > kHelpWidth) {
        help += line + "\n";
        line.assign(kHelpIndent, ' ');
      }
      line += (line.size() > kHelpIndent ? " " : "") + word;
    }
    return help + line + "\n";
  }
};

}  // namespace

int runTool(const std::string& name, CLI::App& app, int argc, char** argv, const Action& run,
            const Action& check) {
  app.name(name);
  app.formatter(std::make_shared<WrappedHelp>());
  // Asked for by the build, which installs both; --help does not show them.
  if (argc == 2 && std::string(argv[1]) == "--man-page") {
    std::fputs(manPage(name, app).c_str(), stdout);
    return kSuccess;
  }
  if (argc == 2 && std::string(argv[1]) == "--bash-completion") {
    std::fputs(bashCompletion(name, app).c_str(), stdout);
    return kSuccess;
  }
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
