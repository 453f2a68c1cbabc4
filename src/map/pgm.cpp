// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/pgm.h"

#include <cctype>
#include <stdexcept>

namespace kestrel {
namespace {

constexpr int kWhite = 255;
constexpr int kMaxValue = 65535;       // of the format
constexpr int kMaxSide = 1000000;      // pixels; larger values mean a broken header
constexpr int kMaxNumber = 100000000;  // stops the parser before an int overflows

bool isSpace(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }
bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// Reads the numbers of the header (and the values of a P2), skipping white space and comments.
class PgmScanner {
 public:
  explicit PgmScanner(const std::string& bytes) : bytes_(bytes), position_(2) {}

  int number(const std::string& what) {
    skipBlank();
    if (position_ >= bytes_.size()) throw std::runtime_error("it ends before its " + what);
    if (!isDigit(bytes_[position_])) throw std::runtime_error("its " + what + " is not a number");
    int value = 0;
    for (; position_ < bytes_.size() && isDigit(bytes_[position_]); ++position_) {
      value = value * 10 + (bytes_[position_] - '0');
      if (value > kMaxNumber) throw std::runtime_error("its " + what + " is too large");
    }
    return value;
  }

  int numberWithin(const std::string& what, int max) {
    const int value = number(what);
    if (value < 1 || value > max) {
      throw std::runtime_error("its " + what + " is " + std::to_string(value) +
                               ", not within 1 to " + std::to_string(max));
    }
    return value;
  }

  /// Skips the single white space between a binary header and the pixels.
  void skipOne() { ++position_; }
  std::size_t left() const { return position_ < bytes_.size() ? bytes_.size() - position_ : 0; }
  int byte() { return static_cast<unsigned char>(bytes_[position_++]); }

 private:
  void skipBlank() {
    while (position_ < bytes_.size()) {
      if (bytes_[position_] == '#') {
        while (position_ < bytes_.size() && bytes_[position_] != '\n') ++position_;
      } else if (isSpace(bytes_[position_])) {
        ++position_;
      } else {
        return;
      }
    }
  }

  const std::string& bytes_;
  std::size_t position_;
};

/// Checked before memory is reserved, because a broken header may ask for gigabytes.
void requireBytes(const PgmScanner& scanner, std::size_t needed) {
  if (scanner.left() < needed) {
    throw std::runtime_error("it is truncated: " + std::to_string(needed) +
                             " bytes of pixels expected, " + std::to_string(scanner.left()) +
                             " found");
  }
}

std::uint8_t scaled(int value, int max) {
  if (value > max) {
    throw std::runtime_error("it has a pixel of " + std::to_string(value) +
                             " above its maximum of " + std::to_string(max));
  }
  return static_cast<std::uint8_t>((value * kWhite + max / 2) / max);
}

}  // namespace

std::string encodePgm(const GrayImage& image, const std::string& comment) {
  std::string bytes = "P5\n# " + comment + "\n" + std::to_string(image.width) + " " +
                      std::to_string(image.height) + "\n255\n";
  bytes.append(image.pixels.begin(), image.pixels.end());
  return bytes;
}

GrayImage decodePgm(const std::string& bytes) {
  const std::string magic = bytes.substr(0, 2);
  if (magic != "P2" && magic != "P5") {
    throw std::runtime_error("it is not a PGM image (it does not begin with P2 or P5); convert it");
  }
  PgmScanner scanner(bytes);
  GrayImage image;
  image.width = scanner.numberWithin("width", kMaxSide);
  image.height = scanner.numberWithin("height", kMaxSide);
  const int max = scanner.numberWithin("maximum value", kMaxValue);
  const std::size_t count =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  const bool binary = magic == "P5";
  const bool wide = max > kWhite;  // two bytes per pixel, high byte first
  scanner.skipOne();
  // A value of a P2 takes at least one digit and a separator, except that the last has no
  // separator.
  requireBytes(scanner, binary ? count * (wide ? 2 : 1) : 2 * count - 1);
  image.pixels.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    int value = 0;
    if (binary) {
      value = scanner.byte();
      if (wide) value = value * (kWhite + 1) + scanner.byte();
    } else {
      value = scanner.number("pixel " + std::to_string(i + 1) + " of " + std::to_string(count));
    }
    image.pixels.push_back(scaled(value, max));
  }
  return image;
}

}  // namespace kestrel
