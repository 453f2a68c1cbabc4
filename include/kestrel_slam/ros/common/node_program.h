// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// What the help of a node says beside its parameters.
struct NodeProgram {
  const char* node;     ///< its name in ROS
  const char* program;  ///< the file that is run
  const char* purpose;  ///< one sentence or two, as lines of at most 100 characters
  const char* launch;   ///< how it is usually started
};

/// The answer to `--help` or `--parameters-markdown`, where an argument asks for it. It needs no
/// ROS master. The places of the table must hold the defaults.
std::optional<std::string> answerTo(const std::vector<std::string>& arguments,
                                    const NodeProgram& program,
                                    const std::vector<Parameter>& table);

}  // namespace kestrel
