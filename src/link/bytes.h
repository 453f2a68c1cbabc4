// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <xxhash.h>

#include <cstdint>
#include <string>

namespace kestrel {

/// Appends a number, little-endian.
template <typename T>
void put(std::string& bytes, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    bytes += static_cast<char>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xFFU);
}

/// Appends length and content.
inline void putText(std::string& bytes, const std::string& text) {
  put(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += text;
}

/// Reads what put() has written. After a number that is not there, ok() is false.
class ByteReader {
 public:
  explicit ByteReader(const std::string& bytes, std::size_t at = 0) : bytes_(bytes), at_(at) {}

  template <typename T>
  T get() {
    if (bytes_.size() - at_ < sizeof(T)) return fail<T>();
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      value |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes_[at_ + i])) << (8 * i);
    at_ += sizeof(T);
    return static_cast<T>(value);
  }

  std::string getText(std::size_t most) {
    const auto length = get<std::uint32_t>();
    if (!ok_ || length > most || length > bytes_.size() - at_) return fail<std::string>();
    at_ += length;
    return bytes_.substr(at_ - length, length);
  }

  bool ok() const { return ok_; }
  std::size_t at() const { return at_; }
  bool atEnd() const { return ok_ && at_ == bytes_.size(); }

 private:
  template <typename T>
  T fail() {
    ok_ = false;
    at_ = bytes_.size();
    return T();
  }

  const std::string& bytes_;
  std::size_t at_;
  bool ok_ = true;
};

/// Bytes of a checksum.
constexpr std::size_t kChecksumBytes = 8;

inline std::uint64_t checksumOf(const std::string& bytes) {
  return XXH64(bytes.data(), bytes.size(), 0);
}

}  // namespace kestrel
