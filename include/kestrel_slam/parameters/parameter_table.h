// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel::parameter_table {

// The rows of a table of parameters: name, unit, place, smallest, largest, description.

inline Parameter number(const char* name, const char* unit,
                        std::variant<double*, int*, bool*, std::string*> value, double min,
                        double max, const char* description) {
  return {name, unit, description, value, min, max, {}};
}

inline Parameter flag(const char* name, bool* value, const char* description) {
  return {name, "", description, value, 0.0, 0.0, {}};
}

inline Parameter text(const char* name, std::string* value, const char* description) {
  return {name, "", description, value, 0.0, 0.0, {}};
}

inline Parameter choice(const char* name, std::string* value, std::vector<std::string> choices,
                        const char* description) {
  return {name, "", description, value, 0.0, 0.0, std::move(choices)};
}

}  // namespace kestrel::parameter_table
