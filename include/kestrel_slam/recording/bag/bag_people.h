// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/recording/true_objects.h"

namespace kestrel {

/// Reads annotated people: messages of the type leg_tracker/Person (pose in the frame of the laser,
/// id). They have no stamp: each belongs to the last scan that was recorded before it. `topic` may
/// be "" if there is only one. Throws std::runtime_error with the name of the bag and a list of its
/// topics.
std::vector<TrueObject> readBagPeople(const std::string& path, const std::string& topic);

}  // namespace kestrel
