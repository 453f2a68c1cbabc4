// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// Parameters that have no effect in a node, and the reason. The reason is the end of the sentence
/// "The parameter ~name has no effect: ...".
using UnneededParameters = std::map<std::string, std::string>;

/// Adds every parameter of a table with the same reason.
void addUnneeded(const std::vector<Parameter>& table, const std::string& reason,
                 UnneededParameters& unneeded);

/// Reads the private parameters of a node into the variables of its table. If a text parameter is
/// set to a list, its items are joined with commas. An old name is accepted with a warning. If both
/// names are set, the new name is used. Logs the parameters that have no effect with the reason,
/// and unknown parameters with the nearest valid name. Throws std::invalid_argument if a parameter
/// has a wrong type or is out of range. The message contains the name, the value and the allowed
/// values.
///
/// `limited`: names of parameters of an older node that had no limits. A number outside of the
/// limits is limited, with a warning, so that old launch files start.
void readPrivateParameters(const ros::NodeHandle& private_nh,
                           const std::vector<Parameter>& parameters,
                           const UnneededParameters& unneeded,
                           const std::set<std::string>& limited = {});

/// Both functions throw std::invalid_argument with the name of the parameter.
void requireName(const std::string& parameter, const std::string& value);
void requireDistinct(const std::string& parameter, const std::string& frame,
                     const std::string& other);

}  // namespace kestrel
