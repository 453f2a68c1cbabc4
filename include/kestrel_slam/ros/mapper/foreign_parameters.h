// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/ros/common/private_parameters.h"

namespace kestrel {

/// Parameters of gmapping and slam_toolbox, each with what to set here, so that a launch file that
/// was written for them says in the log what to change.
UnneededParameters foreignParameters();

}  // namespace kestrel
