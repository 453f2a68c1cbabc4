// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace kestrel {

/// True if the file is a gzip, bzip2 or xz file. Throws like readMagic().
bool isCompressed(const std::string& path);

/// The first bytes of a file, decompressed if necessary. Throws like readMagic().
std::string startOf(const std::string& path);

/// What a file or folder is that the tools cannot read, and what to do with it, as in "is a ROS 2
/// bag; convert it ...". "" if it is nothing that is known here. Throws like readMagic().
std::string foreignKind(const std::string& path);

}  // namespace kestrel
