// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kestrel {

/// A gray image, row-major from the upper left corner, 0 black to 255 white.
struct GrayImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;
};

/// The bytes of a binary PGM (P5) with one comment line.
std::string encodePgm(const GrayImage& image, const std::string& comment);

/// Decodes a PGM, binary (P5) or text (P2), with comments. Any maximum value up to 65535 is scaled
/// to 255. Throws std::runtime_error with the reason; the name of the file is not known here.
GrayImage decodePgm(const std::string& bytes);

}  // namespace kestrel
