// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// Sets the parameters of a flat YAML file (`name: value`), which may leave out any. Throws
/// std::runtime_error that names the file, the line, the parameter and what is allowed.
void loadParameters(const std::string& path, SlamConfig& config);

/// All parameters with their defaults as a commented YAML file: unit, range, meaning.
std::string defaultParametersYaml();
/// The same of the pose filter.
std::string defaultFilterParametersYaml();

}  // namespace kestrel
