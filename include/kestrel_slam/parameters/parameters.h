// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "kestrel_slam/pipeline/slam_config.h"

namespace kestrel {

/// One named parameter, bound to its place in a SlamConfig. Names follow hector_mapping where it
/// has the parameter.
struct Parameter {
  std::string name;
  std::string unit;  ///< "" where it has none
  std::string description;
  std::variant<double*, int*, bool*, std::string*> value;
  double min = 0.0;  ///< inclusive limits of numbers
  double max = 0.0;
  std::vector<std::string> choices;  ///< allowed values of a text
};

/// The table of all parameters, bound to `config`, which must outlive it.
std::vector<Parameter> parametersOf(SlamConfig& config);

/// Those of the scan projector alone (`projector` and `attitude` of the config).
std::vector<Parameter> projectorParametersOf(SlamConfig& config);

/// The value of a parameter as text ("0.05", "true", "hybrid").
std::string valueText(const Parameter& parameter);

/// Sets the place of one parameter from text. Throws std::invalid_argument that names the
/// parameter, the value and what is allowed. A text without choices may be anything.
void setValue(const Parameter& parameter, const std::string& text);

/// Sets one parameter of a table from text. Throws std::invalid_argument that names the parameter,
/// the value and what is allowed; for an unknown name, the nearest valid one.
void setParameter(const std::vector<Parameter>& table, const std::string& name,
                  const std::string& text);
void setParameter(SlamConfig& config, const std::string& name, const std::string& text);

/// Applies settings of the form name=value in turn. Throws std::invalid_argument as setParameter
/// does, also for a setting without '='.
void applySettings(const std::vector<std::string>& settings, const std::vector<Parameter>& table);
/// The same, and validates the whole.
void applySettings(const std::vector<std::string>& settings, SlamConfig& config);

/// The one of `names`, which has at least one, that is nearest to `name` by edit distance.
std::string nearestName(const std::string& name, const std::vector<std::string>& names);

/// Relations between parameters that a single range cannot express (clamps in order, minimum range
/// below the maximum). Throws std::invalid_argument that names them.
void validate(const SlamConfig& config);

}  // namespace kestrel
