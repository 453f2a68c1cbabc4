// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <istream>
#include <memory>
#include <string>

namespace kestrel {

/// The first `count` bytes of a file, or fewer if it is shorter. Throws std::runtime_error with the
/// name of the file if it does not exist, is a folder, a pipe or cannot be read.
std::string readMagic(const std::string& path, std::size_t count);

/// Opens a text file for reading and decompresses it if it is a bzip2, gzip or xz file. Damaged
/// compressed data and disk errors set `bad()` of the stream.
std::unique_ptr<std::istream> openText(const std::string& path);

/// The beginning of a text file, decompressed; by default enough to recognize its format.
std::string readHead(const std::string& path, std::size_t bytes = std::size_t{1} << 16U);

/// Like std::getline, but damaged data and a line of more than 16 MB set `bad()` of the stream.
bool readLine(std::istream& stream, std::string& line);

/// Warning for a stream that became bad after line `line`.
std::string cutOffText(std::size_t line);

/// Parses `text` as a finite number. False if it is anything else.
bool parseFinite(const std::string& text, double& value);

}  // namespace kestrel
