// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace kestrel {

/// Walks through the records of a rosbag (format 2.0) and checks that every length and position in
/// it lies where it can. The rosbag library trusts them: it asks for gigabytes or reads outside of
/// its memory where a few bytes are damaged. Throws std::runtime_error that says at which byte.
void checkBagStructure(const std::string& path);

}  // namespace kestrel
