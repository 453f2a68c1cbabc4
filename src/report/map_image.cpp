// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/map_image.h"

#include <cairo.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

namespace kestrel {
namespace {

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

void check(cairo_status_t status) {
  if (status != CAIRO_STATUS_SUCCESS) {
    throw std::runtime_error(std::string("cannot render the map: ") +
                             cairo_status_to_string(status));
  }
}

/// The value of a block: occupied before free before unknown. The block must overlap the map.
std::int8_t valueOf(const MapSnapshot& map, int first_column, int first_row, int size) {
  std::int8_t value = MapSnapshot::kUnknown;
  for (int row = first_row; row < std::min(first_row + size, map.height); ++row) {
    for (int column = first_column; column < std::min(first_column + size, map.width); ++column) {
      value = std::max(value, map.at(column, row));
    }
  }
  return value;
}

cairo_status_t append(void* target, const unsigned char* data, unsigned int length) {
  static_cast<std::string*>(target)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

/// The indices between which all but a few of the counted cells lie.
std::pair<int, int> coreOf(const std::vector<std::size_t>& counts, std::size_t total) {
  constexpr double kLeftOut = 0.005;  // on each side: what is seen far away through a window
  const auto few = static_cast<std::size_t>(kLeftOut * static_cast<double>(total));
  const auto skip = [few](auto from, auto end) {
    std::size_t sum = 0;
    const auto first =
        std::find_if(from, end, [&](std::size_t count) { return (sum += count) > few; });
    return static_cast<int>(first - from);
  };
  return {skip(counts.begin(), counts.end()),
          static_cast<int>(counts.size()) - skip(counts.rbegin(), counts.rend())};
}

}  // namespace

unsigned char grayOf(std::int8_t cell, const MapGrays& grays) {
  if (cell == MapSnapshot::kUnknown) return grays.unknown;
  return cell == MapSnapshot::kFree ? grays.free : grays.occupied;
}

MapImage renderMap(const MapSnapshot& map, int max_side_pixels, const MapGrays& grays) {
  MapImage image;
  if (map.empty()) return image;
  const int side = std::max(map.width, map.height);
  const int block = (side + max_side_pixels - 1) / max_side_pixels;
  image.cells_per_pixel = block;
  image.width = (map.width + block - 1) / block;
  image.height = (map.height + block - 1) / block;
  // The alpha-only format, because cairo writes it as a gray PNG with one byte per pixel.
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_A8, image.width, image.height),
                        &cairo_surface_destroy);
  check(cairo_surface_status(surface.get()));
  cairo_surface_flush(surface.get());
  unsigned char* const pixels = cairo_image_surface_get_data(surface.get());
  const int stride = cairo_image_surface_get_stride(surface.get());
  for (int y = 0; y < image.height; ++y) {
    const int row = (image.height - 1 - y) * block;
    for (int x = 0; x < image.width; ++x) {
      pixels[static_cast<std::ptrdiff_t>(y) * stride + x] =
          grayOf(valueOf(map, x * block, row, block), grays);
    }
  }
  cairo_surface_mark_dirty(surface.get());
  check(cairo_surface_write_to_png_stream(surface.get(), append, &image.png));
  return image;
}

std::optional<Eigen::AlignedBox2d> wallBox(const MapSnapshot& map) {
  std::vector<std::size_t> columns(static_cast<std::size_t>(map.width));
  std::vector<std::size_t> rows(static_cast<std::size_t>(map.height));
  std::size_t total = 0;
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      if (map.at(column, row) != MapSnapshot::kOccupied) continue;
      ++columns[static_cast<std::size_t>(column)];
      ++rows[static_cast<std::size_t>(row)];
      ++total;
    }
  }
  if (total == 0) return std::nullopt;
  const auto [left, right] = coreOf(columns, total);
  const auto [low, high] = coreOf(rows, total);
  const Eigen::Vector2d origin(map.origin_x, map.origin_y);
  return Eigen::AlignedBox2d(origin + map.resolution_m * Eigen::Vector2d(left, low),
                             origin + map.resolution_m * Eigen::Vector2d(right, high));
}

std::string base64(const std::string& bytes) {
  static constexpr char kAlphabet[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  constexpr unsigned int kSixBits = 0x3f;
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t j = i; j < i + 3; ++j) {
      group = group << 8U | (j < bytes.size() ? static_cast<unsigned char>(bytes[j]) : 0U);
    }
    for (const unsigned int shift : {18U, 12U, 6U, 0U}) {
      text.push_back(kAlphabet[group >> shift & kSixBits]);
    }
  }
  // Padding of the last group of three bytes.
  for (std::size_t missing = (3 - bytes.size() % 3) % 3, i = 1; i <= missing; ++i) {
    text[text.size() - i] = '=';
  }
  return text;
}

}  // namespace kestrel
