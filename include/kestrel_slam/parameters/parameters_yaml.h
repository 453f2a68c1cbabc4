// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// Sets the parameters of a flat YAML file (`name: value`), which may leave out any. An old name is
/// accepted with a warning. Throws std::runtime_error that names the file, the line, the parameter
/// and what is allowed.
void loadParameters(const std::string& path, const std::vector<Parameter>& table,
                    const WarningHandler& warn = printWarning);
void loadParameters(const std::string& path, SlamConfig& config);

/// The same for a YAML text. `source`: what errors call it.
void takeParameters(const std::string& yaml, const std::string& source,
                    const std::vector<Parameter>& table, const WarningHandler& warn = printWarning);

/// All parameters of projector and mapper with their defaults as a commented YAML file.
std::string defaultParametersYaml();
/// The same with the values of `config`.
std::string parametersYaml(SlamConfig config);
/// The defaults of the pose filter.
std::string defaultFilterParametersYaml();

}  // namespace kestrel
