// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel::parameter_table {

// The rows of a parameter table: name, unit, place, smallest value, largest value, effect.

/// As largest value: there is none.
constexpr double kNoLimit = std::numeric_limits<double>::infinity();

inline Parameter number(const char* name, const char* unit, Parameter::Place value, double min,
                        double max, const char* description) {
  Parameter row;
  row.name = name;
  row.unit = unit;
  row.description = description;
  row.value = value;
  row.min = min;
  row.max = max;
  return row;
}

inline Parameter flag(const char* name, bool* value, const char* description) {
  return number(name, "", value, 0.0, 0.0, description);
}

inline Parameter text(const char* name, std::string* value, const char* description) {
  return number(name, "", value, 0.0, 0.0, description);
}

inline Parameter choice(const char* name, std::string* value, std::vector<std::string> choices,
                        const char* description) {
  Parameter row = text(name, value, description);
  row.choices = std::move(choices);
  return row;
}

/// The row with a name that it had in earlier versions.
inline Parameter renamed(const char* old_name, Parameter row) {
  row.old_names.emplace_back(old_name);
  return row;
}

/// The row of a parameter that may change while a node runs.
inline Parameter live(Parameter row) {
  row.live = true;
  return row;
}

/// The rows under one heading.
inline std::vector<Parameter> group(const char* heading, std::vector<Parameter> rows) {
  for (Parameter& row : rows) row.group = heading;
  return rows;
}

inline std::vector<Parameter> joined(std::initializer_list<std::vector<Parameter>> tables) {
  std::vector<Parameter> all;
  for (const std::vector<Parameter>& table : tables) {
    all.insert(all.end(), table.begin(), table.end());
  }
  return all;
}

}  // namespace kestrel::parameter_table
