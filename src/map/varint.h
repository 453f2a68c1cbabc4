// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace kestrel {

/// Appends numbers to bytes, seven bits per byte, the lowest first. The highest bit of a byte says
/// that more follow. Small numbers are short.
class VarintWriter {
 public:
  void add(std::uint32_t value) {
    for (; value > 0x7FU; value >>= 7U) bytes_.push_back(static_cast<char>(value | 0x80U));
    bytes_.push_back(static_cast<char>(value));
  }
  /// The sign goes into the lowest bit, so that small negative numbers are short, too.
  void addSigned(std::int32_t value) {
    add((static_cast<std::uint32_t>(value) << 1U) ^ (value < 0 ? ~0U : 0U));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Reads what VarintWriter wrote. Throws std::invalid_argument where it cannot be.
class VarintReader {
 public:
  explicit VarintReader(const std::string& bytes) : bytes_(bytes) {}

  std::uint32_t next() {
    std::uint32_t value = nextByte();
    if (value < 0x80U) return value;
    value &= 0x7FU;
    for (unsigned shift = 7;; shift += 7) {
      const std::uint32_t byte = nextByte();
      if (shift == 28 && byte > 0xFU) throw std::invalid_argument("a number is too large");
      value |= (byte & 0x7FU) << shift;
      if (byte < 0x80U) return value;
    }
  }
  std::int32_t nextSigned() {
    const std::uint32_t value = next();
    return static_cast<std::int32_t>((value >> 1U) ^ (~(value & 1U) + 1U));
  }
  std::size_t left() const { return bytes_.size() - position_; }

 private:
  std::uint32_t nextByte() {
    if (position_ == bytes_.size()) throw std::invalid_argument("it ends too early");
    return static_cast<unsigned char>(bytes_[position_++]);
  }

  const std::string& bytes_;
  std::size_t position_ = 0;
};

}  // namespace kestrel
