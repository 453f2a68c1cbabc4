// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/cloud_file.h"

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "affixes.h"
#include "kestrel_slam/recording/text_stream.h"
#include "kestrel_slam/sensor/point_buffer.h"

namespace kestrel {
namespace {

constexpr std::size_t kNuScenesValues = 5, kKittiValues = 4;  // per point

/// The header of a PCD file.
struct PcdHeader {
  std::vector<std::string> names, types;
  std::vector<std::uint64_t> sizes, counts;
  std::uint64_t width = 0, height = 1;
  std::string data;  ///< ascii, binary or binary_compressed
};

template <typename T>
std::vector<T> restOf(std::istringstream& fields) {
  return {std::istream_iterator<T>(fields), std::istream_iterator<T>()};
}

PcdHeader readHeader(std::istream& file) {
  PcdHeader header;
  for (std::string line; header.data.empty() && std::getline(file, line);) {
    std::istringstream fields(line);
    std::string key;
    fields >> key;
    if (key == "FIELDS") header.names = restOf<std::string>(fields);
    if (key == "SIZE") header.sizes = restOf<std::uint64_t>(fields);
    if (key == "TYPE") header.types = restOf<std::string>(fields);
    if (key == "COUNT") header.counts = restOf<std::uint64_t>(fields);
    if (key == "WIDTH") fields >> header.width;
    if (key == "HEIGHT") fields >> header.height;
    if (key == "DATA") fields >> header.data;
  }
  const std::size_t count = header.names.size();
  if (header.counts.empty()) header.counts.assign(count, 1);
  if (count == 0 || header.sizes.size() != count || header.types.size() != count ||
      header.counts.size() != count || header.data.empty()) {
    throw std::invalid_argument(
        "the PCD header is invalid: FIELDS, SIZE, TYPE and COUNT must have the same number of "
        "entries, and DATA must follow");
  }
  return header;
}

int typeOf(const std::string& letter, std::uint64_t size) {
  if (letter == "F") return size == 8 ? PointField::kFloat64 : PointField::kFloat32;
  const bool is_signed = letter == "I";
  switch (size) {
    case 1:
      return is_signed ? PointField::kInt8 : PointField::kUint8;
    case 2:
      return is_signed ? PointField::kInt16 : PointField::kUint16;
    default:
      return is_signed ? PointField::kInt32 : PointField::kUint32;
  }
}

PointBuffer layoutOf(const PcdHeader& header) {
  constexpr std::uint64_t kMaxSize = 8, kMaxCount = 1U << 16U;
  PointBuffer buffer;
  for (std::size_t i = 0; i < header.names.size(); ++i) {
    if (header.sizes[i] == 0 || header.sizes[i] > kMaxSize || header.counts[i] > kMaxCount) {
      throw std::invalid_argument("field " + header.names[i] + " of the PCD header is invalid");
    }
    buffer.fields.push_back(
        {header.names[i], buffer.point_step, typeOf(header.types[i], header.sizes[i])});
    buffer.point_step += header.sizes[i] * header.counts[i];
  }
  buffer.width = header.width;
  buffer.height = header.height;
  buffer.row_step = header.width * buffer.point_step;
  return buffer;
}

PointCloud unpackBytes(PointBuffer buffer, const std::vector<std::uint8_t>& bytes) {
  buffer.data = bytes.data();
  buffer.size = bytes.size();
  return unpackPoints(buffer, 0.0);
}

/// Reads all numbers as float64, because the sizes of the header have no meaning for text.
PointCloud readAscii(std::istream& file, const PcdHeader& header) {
  PointBuffer buffer;
  for (std::size_t i = 0; i < header.names.size(); ++i) {
    buffer.fields.push_back({header.names[i], buffer.point_step, PointField::kFloat64});
    buffer.point_step += header.counts[i] * sizeof(double);
  }
  std::vector<double> values;
  for (std::string field; file >> field;) {
    char* end = nullptr;
    values.push_back(std::strtod(field.c_str(), &end));
    if (*end != '\0') throw std::invalid_argument("'" + field + "' is not a number");
  }
  buffer.width = header.width * header.height;
  buffer.row_step = buffer.width * buffer.point_step;
  buffer.data = reinterpret_cast<const std::uint8_t*>(values.data());
  buffer.size = values.size() * sizeof(double);
  return unpackPoints(buffer, 0.0);
}

std::vector<std::uint8_t> restOf(std::istream& file) {
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

PointCloud readPcd(std::istream& file) {
  const PcdHeader header = readHeader(file);
  if (header.data == "ascii") return readAscii(file, header);
  if (header.data == "binary") return unpackBytes(layoutOf(header), restOf(file));
  throw std::invalid_argument("the points are stored as " + header.data +
                              "; convert the file with `pcl_convert_pcd_ascii_binary FILE OUT 1`");
}

PointCloud readNumbers(std::istream& file, std::size_t values_per_point) {
  const std::vector<std::uint8_t> bytes = restOf(file);
  PointBuffer buffer;
  std::size_t offset = 0;
  for (const char* name : {"x", "y", "z"}) {
    buffer.fields.push_back({name, offset, PointField::kFloat32});
    offset += sizeof(float);
  }
  buffer.point_step = values_per_point * sizeof(float);
  if (bytes.size() % buffer.point_step != 0) {
    throw std::invalid_argument("the size of " + std::to_string(bytes.size()) +
                                " bytes is not a multiple of the point size of " +
                                std::to_string(buffer.point_step) + " bytes");
  }
  buffer.width = bytes.size() / buffer.point_step;
  buffer.row_step = bytes.size();
  return unpackBytes(buffer, bytes);
}

bool isPcd(const std::string& path) {
  static const std::string kComment = "# .PCD", kVersion = "VERSION";
  const std::string magic = readMagic(path, kVersion.size());
  return magic == kVersion || magic.compare(0, kComment.size(), kComment) == 0;
}

PointCloud readAny(const std::string& path) {
  const bool pcd = isPcd(path);
  std::ifstream file(path, std::ios::binary);
  if (pcd) return readPcd(file);
  if (endsWith(path, ".pcd.bin")) return readNumbers(file, kNuScenesValues);
  if (endsWith(path, ".bin")) return readNumbers(file, kKittiValues);
  throw std::invalid_argument("is not a point cloud; use a rosbag, a .pcd, .pcd.bin or .bin file");
}

}  // namespace

PointCloud readCloudFile(const std::string& path) {
  try {
    return readAny(path);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

}  // namespace kestrel
