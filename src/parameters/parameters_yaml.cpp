// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/parameters/parameters_yaml.h"

#include <yaml-cpp/yaml.h>

#include <sstream>
#include <stdexcept>

#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/parameters/filter_parameters.h"

namespace kestrel {
namespace {

const char* const kIntroduction =
    "# Parameters of kestrel_slam with their defaults, for mapper_node, scan_projector_node and\n"
    "# map_recording.\n"
    "# Keep only the lines that you change; a missing parameter keeps its default.\n"
    "# This file is the output of `map_recording --list-parameters`.\n";
const char* const kGivenIntroduction =
    "# All parameters of kestrel_slam with the values that were given.\n";
const char* const kFilterIntroduction =
    "# Parameters of the pose filter with their defaults, for pose_filter_node.\n"
    "# Keep only the lines that you change; a missing parameter keeps its default.\n"
    "# This file is the output of `measure_filter --list-parameters`.\n";

std::string lineOf(const YAML::Mark& mark) { return "line " + std::to_string(mark.line + 1); }

void setFrom(const YAML::Node& key, const YAML::Node& value, const std::vector<Parameter>& table,
             const WarningHandler& warn) {
  if (!value.IsScalar()) {
    throw std::invalid_argument("'" + key.Scalar() + "' is not a single value; one 'name: value' " +
                                "a line is expected");
  }
  setParameter(table, key.Scalar(), value.Scalar(), warn);
}

/// "0.1 to 5 m"; "any text" for a text without choices.
std::string rangeText(const Parameter& parameter) {
  const std::string limits = limitsText(parameter);
  if (limits.empty()) return "any text";
  return limits + (parameter.unit.empty() ? "" : " " + parameter.unit);
}

/// The parameter server refuses a value that is not there: an empty text needs its quotes.
std::string yamlValue(const Parameter& parameter) {
  const std::string value = valueText(parameter);
  return value.empty() ? "''" : value;
}

std::string yamlOf(const std::vector<Parameter>& parameters, const char* introduction) {
  std::ostringstream yaml;
  yaml << introduction;
  std::string group;
  for (const Parameter& parameter : parameters) {
    if (parameter.group != group) {
      group = parameter.group;
      yaml << "\n# ---- " << group << "\n";
    }
    yaml << "\n# " << parameter.description << "\n# " << rangeText(parameter) << "\n"
         << parameter.name << ": " << yamlValue(parameter) << "\n";
  }
  return yaml.str();
}

}  // namespace

void loadParameters(const std::string& path, const std::vector<Parameter>& table,
                    const WarningHandler& warn) {
  takeParameters(readFile(path), path, table, warn);
}

void takeParameters(const std::string& yaml, const std::string& source,
                    const std::vector<Parameter>& table, const WarningHandler& warn) {
  YAML::Node root;
  try {
    root = YAML::Load(yaml);
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(source + ", " + lineOf(error.mark) + ": no valid YAML: " + error.msg);
  }
  if (root.IsNull()) return;  // nothing but comments
  if (!root.IsMap()) {
    throw std::runtime_error(source + ": one 'name: value' a line is expected");
  }
  for (const auto& entry : root) {
    try {
      setFrom(entry.first, entry.second, table, warn);
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(source + ", " + lineOf(entry.first.Mark()) + ": " + error.what());
    }
  }
}

void loadParameters(const std::string& path, SlamConfig& config) {
  loadParameters(path, parametersOf(config));
}

std::string defaultParametersYaml() {
  SlamConfig config;
  return yamlOf(parametersOf(config), kIntroduction);
}

std::string parametersYaml(SlamConfig config) {
  return yamlOf(parametersOf(config), kGivenIntroduction);
}

std::string defaultFilterParametersYaml() {
  PoseFilterConfig config;
  return yamlOf(parametersOf(config), kFilterIntroduction);
}

}  // namespace kestrel
