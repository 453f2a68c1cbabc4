// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace kestrel {

/// The commit that was built, as `38c8bdaa7aa8`; with `-modified` if files differ from it;
/// `unknown` if the sources were built outside of a git clone.
const char* builtCommit();

/// The hash of the content of one file, or of several files in the order of their names, as 32
/// hexadecimal digits. For one file it is what `xxh128sum FILE` prints. Throws std::runtime_error.
std::string hashOfFiles(std::vector<std::string> paths);

/// The same for a text.
std::string hashOfText(const std::string& text);

}  // namespace kestrel
