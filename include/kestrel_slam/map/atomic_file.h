// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace kestrel {

/// Writes `content` to a temporary file in the same folder and renames it to `path`. So a reader
/// never sees an incomplete file, and an older file remains if writing fails. Throws
/// std::runtime_error with the file and the reason.
void writeFileAtomically(const std::string& path, const std::string& content);

/// The content of a file. Throws std::runtime_error with the file and the reason.
std::string readFile(const std::string& path);

}  // namespace kestrel
