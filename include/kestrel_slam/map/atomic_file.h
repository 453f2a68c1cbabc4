// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace kestrel {

/// Writes `content` to `path` by way of a temporary file in the same folder that is then renamed,
/// so that no reader sees half a file and a failure leaves an older file as it was. Throws
/// std::runtime_error that names the file and the reason.
void writeFileAtomically(const std::string& path, const std::string& content);

/// The whole content of a file. Throws std::runtime_error that names the file and the reason.
std::string readFile(const std::string& path);

}  // namespace kestrel
