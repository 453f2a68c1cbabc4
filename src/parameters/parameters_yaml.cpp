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
    "# Parameters of kestrel_slam with their defaults, for the live nodes and for map_recording.\n"
    "# Keep only what you change; whatever is missing keeps its default.\n"
    "# This file is the output of `map_recording --list-parameters`.\n";
const char* const kFilterIntroduction =
    "# Parameters of the pose filter with their defaults, for pose_filter_node.\n"
    "# Keep only what you change; whatever is missing keeps its default.\n"
    "# This file is the output of `measure_filter --list-parameters`.\n";

std::string lineOf(const YAML::Mark& mark) { return "line " + std::to_string(mark.line + 1); }

void setFrom(const YAML::Node& key, const YAML::Node& value, SlamConfig& config) {
  if (!value.IsScalar()) {
    throw std::invalid_argument("'" + key.Scalar() + "' is not a single value; one 'name: value' " +
                                "a line is expected");
  }
  setParameter(config, key.Scalar(), value.Scalar());
}

std::string rangeText(const Parameter& parameter) {
  std::ostringstream text;
  if (!parameter.choices.empty()) {
    for (const std::string& choice : parameter.choices) {
      text << (text.tellp() > 0 ? ", " : "") << choice;
    }
  } else if (std::holds_alternative<bool*>(parameter.value)) {
    text << "true, false";
  } else {
    text << parameter.min << " to " << parameter.max;
    if (!parameter.unit.empty()) text << " " << parameter.unit;
  }
  return text.str();
}

std::string yamlOf(const std::vector<Parameter>& parameters, const char* introduction) {
  std::ostringstream yaml;
  yaml << introduction;
  for (const Parameter& parameter : parameters) {
    yaml << "\n# " << parameter.description << "\n# " << rangeText(parameter) << "\n"
         << parameter.name << ": " << valueText(parameter) << "\n";
  }
  return yaml.str();
}

}  // namespace

void loadParameters(const std::string& path, SlamConfig& config) {
  const std::string text = readFile(path);
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(path + ", " + lineOf(error.mark) + ": no valid YAML: " + error.msg);
  }
  if (root.IsNull()) return;  // nothing but comments
  if (!root.IsMap()) {
    throw std::runtime_error(path + ": one 'name: value' a line is expected");
  }
  for (const auto& entry : root) {
    try {
      setFrom(entry.first, entry.second, config);
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(path + ", " + lineOf(entry.first.Mark()) + ": " + error.what());
    }
  }
}

std::string defaultParametersYaml() {
  SlamConfig config;
  return yamlOf(parametersOf(config), kIntroduction);
}

std::string defaultFilterParametersYaml() {
  PoseFilterConfig config;
  return yamlOf(parametersOf(config), kFilterIntroduction);
}

}  // namespace kestrel
