// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <map>
#include <string>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// Reads the private parameters of a node into the places of its table. A list for a text is joined
/// with commas. Says so where a parameter has no effect and why (`unneeded`: reason by name), and
/// where one is unknown, with the nearest valid name. Throws std::invalid_argument that names a
/// parameter of a wrong type or out of range, its value and what is allowed.
void readPrivateParameters(const ros::NodeHandle& private_nh,
                           const std::vector<Parameter>& parameters,
                           const std::map<std::string, std::string>& unneeded);

/// Throw std::invalid_argument that names the parameter.
void requireName(const std::string& parameter, const std::string& value);
void requireDistinct(const std::string& parameter, const std::string& frame,
                     const std::string& other);

}  // namespace kestrel
