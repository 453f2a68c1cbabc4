// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// Texts for the help of a node, in addition to its parameters.
struct NodeProgram {
  const char* node;     ///< its name in ROS
  const char* program;  ///< the file name of the executable
  const char* purpose;  ///< one or two sentences, in lines of at most 100 characters
  const char* launch;   ///< the usual start command
};

/// Returns the output for `--help` or `--parameters-markdown` if one of the arguments is given.
/// Needs no ROS master. The variables of the table must contain the defaults.
std::optional<std::string> answerTo(const std::vector<std::string>& arguments,
                                    const NodeProgram& program,
                                    const std::vector<Parameter>& table);

/// What to tell a user whose arguments have no effect, for example those of another package's node;
/// "" if there are none.
std::string unusedArguments(int argc, char** argv);

}  // namespace kestrel
