// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace kestrel {

/// Replaces a file in one step: a reader, or whoever looks after the process was killed or the
/// power failed, finds the whole old or the whole new file. If the path is a symbolic link, the
/// link is replaced and its target is not touched. Refuses pipes and devices. Throws
/// std::runtime_error with the file and the reason.
void writeFileAtomically(const std::string& path, const std::string& content);

/// The content of a plain file. Throws std::runtime_error with the file and the reason.
std::string readFile(const std::string& path);

}  // namespace kestrel
