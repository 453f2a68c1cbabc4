// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <map>
#include <string>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// Why the parameter of each name has no effect in a node, as the end of the sentence "The
/// parameter ~name has no effect: ...".
using UnneededParameters = std::map<std::string, std::string>;

/// Adds every parameter of a table with the same reason.
void addUnneeded(const std::vector<Parameter>& table, const std::string& reason,
                 UnneededParameters& unneeded);

/// Reads the private parameters of a node into the places of its table. A list for a text is joined
/// with commas. An old name is accepted with a warning; the new name wins where both are set. Says
/// which parameters have no effect and why, and which are unknown, with the nearest valid name.
/// Throws std::invalid_argument that names a parameter of a wrong type or out of range, its value
/// and what is allowed.
void readPrivateParameters(const ros::NodeHandle& private_nh,
                           const std::vector<Parameter>& parameters,
                           const UnneededParameters& unneeded);

/// Throw std::invalid_argument that names the parameter.
void requireName(const std::string& parameter, const std::string& value);
void requireDistinct(const std::string& parameter, const std::string& frame,
                     const std::string& other);

}  // namespace kestrel
