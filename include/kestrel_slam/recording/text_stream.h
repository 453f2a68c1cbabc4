// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <istream>
#include <memory>
#include <string>

namespace kestrel {

/// The first `count` bytes of a file, or fewer where it is shorter. Throws std::runtime_error that
/// names the file where it does not exist, is a folder or cannot be read.
std::string readMagic(const std::string& path, std::size_t count);

/// Opens a text file for reading, unpacked on the way where its first bytes say bzip2, gzip or
/// xz.
/// Damaged compressed data sets `bad()` of the stream, as does an error of the disk.
std::unique_ptr<std::istream> openText(const std::string& path);

/// The beginning of a text file, unpacked: enough for the first lines of any recording.
std::string readHead(const std::string& path);

/// What to tell the user where the stream of a recording went bad after a line.
std::string cutOffText(std::size_t line);

/// Reads a number that fills the whole of `text` and is finite; false otherwise.
bool parseFinite(const std::string& text, double& value);

}  // namespace kestrel
