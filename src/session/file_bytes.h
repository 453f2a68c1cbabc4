// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace kestrel {

/// Appends the lowest `bytes` bytes of a number, the lowest first.
inline void appendNumber(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i, value >>= 8U) out.push_back(static_cast<char>(value & 0xFFU));
}

/// A number of `bytes` bytes at `offset`, which must be in the text.
inline std::uint64_t numberAt(const std::string& in, std::uint64_t offset, int bytes) {
  std::uint64_t value = 0;
  for (int i = bytes; i-- > 0;) {
    value = value << 8U | static_cast<unsigned char>(in[offset + static_cast<std::uint64_t>(i)]);
  }
  return value;
}

std::uint64_t checksumOf(const std::string& bytes, std::uint64_t offset, std::uint64_t length);
/// Of two parts, one after the other.
std::uint64_t checksumOf(const std::string& bytes, std::uint64_t offset, std::uint64_t length,
                         std::uint64_t next_offset, std::uint64_t next_length);

std::string pack(const std::string& content);
/// Throws std::runtime_error if the result has not exactly `content_bytes` bytes. Takes no more
/// memory than the result has, whatever `content_bytes` says.
std::string unpack(const char* packed, std::size_t packed_bytes, std::uint64_t content_bytes);

}  // namespace kestrel
