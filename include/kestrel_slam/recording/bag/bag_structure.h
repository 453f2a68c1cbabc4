// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace kestrel {

/// Checks that all lengths and positions in the records of a rosbag (format 2.0) are valid. The
/// rosbag library does not check them: with a few damaged bytes it allocates gigabytes or reads
/// outside of its memory. Throws std::runtime_error with the position of the damage.
void checkBagStructure(const std::string& path);

}  // namespace kestrel
