// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "kestrel_slam/pipeline/slam_config.h"

namespace kestrel {

/// One named parameter, bound to its place in a configuration. Names follow hector_mapping where it
/// has the parameter.
struct Parameter {
  using Place = std::variant<double*, int*, bool*, std::string*>;

  std::string name;
  std::string unit;         ///< "" where it has none
  std::string description;  ///< its effect, one sentence
  Place value;
  double min = 0.0;                         ///< inclusive limits of numbers
  double max = 0.0;                         ///< infinite: no upper limit
  std::vector<std::string> choices = {};    ///< allowed values of a text; empty: any text
  std::string group = {};                   ///< heading above the parameter in lists
  std::vector<std::string> old_names = {};  ///< still accepted, with a warning
  bool live = false;                        ///< may change while a node runs
};

/// The table of all parameters of projector and mapper, bound to `config`, which must outlive it.
std::vector<Parameter> parametersOf(SlamConfig& config);

/// Parts of that table: map and matching; the projection of scans; the attitude from the IMU.
std::vector<Parameter> mappingParametersOf(SlamConfig& config);
std::vector<Parameter> projectionParametersOf(SlamConfig& config);
std::vector<Parameter> attitudeParametersOf(SlamConfig& config);

/// The value of a parameter as text ("0.05", "true", "hybrid").
std::string valueText(const Parameter& parameter);

/// The allowed values without the unit: "0.005 to 1", "0 or more", "true, false", "icp, hybrid"; ""
/// where any text is allowed.
std::string limitsText(const Parameter& parameter);

/// Takes one sentence for the user.
using WarningHandler = std::function<void(const std::string&)>;

/// Writes "warning: <sentence>" to the standard error.
void printWarning(const std::string& sentence);

/// Sets the place of one parameter from text. Throws std::invalid_argument that names the
/// parameter, the value and what is allowed. A text without choices may be anything.
void setValue(const Parameter& parameter, const std::string& text);

/// Sets one parameter of a table from text. An old name is accepted with a warning. Throws
/// std::invalid_argument that names the parameter, the value and what is allowed; for an unknown
/// name, the nearest valid one.
void setParameter(const std::vector<Parameter>& table, const std::string& name,
                  const std::string& text, const WarningHandler& warn = printWarning);
void setParameter(SlamConfig& config, const std::string& name, const std::string& text);

/// Applies settings of the form name=value in turn. Throws std::invalid_argument as setParameter
/// does, also for a setting without '='.
void applySettings(const std::vector<std::string>& settings, const std::vector<Parameter>& table,
                   const WarningHandler& warn = printWarning);
/// The same, and validates the whole.
void applySettings(const std::vector<std::string>& settings, SlamConfig& config);

/// The one of `names`, which has at least one, that is nearest to `name` by edit distance.
std::string nearestName(const std::string& name, const std::vector<std::string>& names);

/// Checks every limit, and the relations between parameters (clamps in order, minimum range below
/// the maximum). Throws std::invalid_argument that names the parameters.
void validate(const SlamConfig& config);

}  // namespace kestrel
