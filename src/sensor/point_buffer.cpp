// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/point_buffer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "kestrel_slam/sensor/point_times.h"

namespace kestrel {
namespace {

constexpr double kNanosecond = 1e-9;  // s

std::size_t sizeOf(int type) {
  switch (type) {
    case PointField::kInt8:
    case PointField::kUint8:
      return 1;
    case PointField::kInt16:
    case PointField::kUint16:
      return 2;
    case PointField::kInt32:
    case PointField::kUint32:
    case PointField::kFloat32:
      return 4;
    case PointField::kFloat64:
      return 8;
    default:
      return 0;
  }
}

/// Reads a number. This machine is little-endian, as are all platforms of ROS 1.
template <typename T>
T numberAt(const std::uint8_t* bytes, bool big_endian) {
  T value;
  if (!big_endian) {
    std::memcpy(&value, bytes, sizeof value);
    return value;
  }
  std::array<std::uint8_t, sizeof(T)> swapped;
  std::reverse_copy(bytes, bytes + sizeof(T), swapped.begin());
  std::memcpy(&value, swapped.data(), sizeof value);
  return value;
}

double valueAt(const std::uint8_t* point, const PointField& field, bool big_endian) {
  const std::uint8_t* bytes = point + field.offset;
  switch (field.type) {
    case PointField::kFloat32:
      return numberAt<float>(bytes, big_endian);
    case PointField::kFloat64:
      return numberAt<double>(bytes, big_endian);
    case PointField::kInt32:
      return numberAt<std::int32_t>(bytes, big_endian);
    default:
      return numberAt<std::uint32_t>(bytes, big_endian);
  }
}

const PointField* findField(const PointBuffer& buffer, const std::string& name) {
  const auto field = std::find_if(buffer.fields.begin(), buffer.fields.end(),
                                  [&](const PointField& f) { return f.name == name; });
  return field == buffer.fields.end() ? nullptr : &*field;
}

std::string listOf(const std::vector<PointField>& fields) {
  if (fields.empty()) return "none";
  std::string text;
  for (const PointField& field : fields) text += (text.empty() ? "" : ", ") + field.name;
  return text;
}

void requireInside(const PointBuffer& buffer, const PointField& field) {
  if (field.offset + sizeOf(field.type) <= buffer.point_step) return;
  throw std::invalid_argument(
      "field " + field.name +
      " of the cloud lies outside of its point: " + std::to_string(field.offset) + " + " +
      std::to_string(sizeOf(field.type)) + " bytes of " + std::to_string(buffer.point_step));
}

std::array<PointField, 3> requireCoordinates(const PointBuffer& buffer) {
  std::string missing;
  for (const char* name : {"x", "y", "z"}) {
    if (findField(buffer, name) == nullptr)
      missing += (missing.empty() ? "" : ", ") + std::string(name);
  }
  if (!missing.empty()) {
    throw std::invalid_argument("the cloud has no field " + missing +
                                "; its fields: " + listOf(buffer.fields));
  }
  const std::array<PointField, 3> fields = {*findField(buffer, "x"), *findField(buffer, "y"),
                                            *findField(buffer, "z")};
  for (const PointField& field : fields) {
    if (field.type != PointField::kFloat32 && field.type != PointField::kFloat64) {
      throw std::invalid_argument(
          "field " + field.name + " of the cloud has the unsupported type " +
          std::to_string(field.type) + "; float32 (7) or float64 (8) is needed");
    }
    requireInside(buffer, field);
  }
  return fields;
}

void requireBytes(const PointBuffer& buffer) {
  if (buffer.width == 0 || buffer.height == 0) {
    throw std::invalid_argument("the cloud has zero points");
  }
  // Divisions instead of products: the values of a corrupt header may overflow.
  if (buffer.point_step == 0 || buffer.row_step / buffer.point_step < buffer.width) {
    throw std::invalid_argument("a row of the cloud has " + std::to_string(buffer.row_step) +
                                " bytes, too few for " + std::to_string(buffer.width) +
                                " points of " + std::to_string(buffer.point_step) + " bytes");
  }
  if (buffer.size / buffer.row_step < buffer.height) {
    throw std::invalid_argument("the payload of the cloud has " + std::to_string(buffer.size) +
                                " bytes, fewer than " + std::to_string(buffer.height) +
                                " rows of " + std::to_string(buffer.row_step) + " bytes");
  }
}

/// The field with the time of the points. A field with a smaller type is not a time.
std::optional<PointField> timeField(const PointBuffer& buffer) {
  for (const PointField& field : buffer.fields) {
    if (!isPointTime(field.name) || sizeOf(field.type) < sizeof(std::uint32_t)) continue;
    requireInside(buffer, field);
    return field;
  }
  return std::nullopt;
}

template <typename Visit>
void forEachPoint(const PointBuffer& buffer, Visit visit) {
  for (std::uint64_t row = 0; row < buffer.height; ++row) {
    const std::uint8_t* point = buffer.data + row * buffer.row_step;
    for (std::uint64_t i = 0; i < buffer.width; ++i, point += buffer.point_step) visit(point);
  }
}

void readTimes(const PointBuffer& buffer, const PointField& field, PointCloud& cloud) {
  std::vector<double> values;
  values.reserve(cloud.points.size());
  forEachPoint(buffer, [&](const std::uint8_t* bytes) {
    values.push_back(valueAt(bytes, field, buffer.big_endian));
  });
  const bool integer = field.type == PointField::kInt32 || field.type == PointField::kUint32;
  setPointTimes(values, integer ? kNanosecond : 1.0, cloud);
}

}  // namespace

PointCloud unpackPoints(const PointBuffer& buffer, double stamp) {
  const auto [x, y, z] = requireCoordinates(buffer);
  requireBytes(buffer);
  PointCloud cloud;
  cloud.stamp = stamp;
  cloud.points.reserve(static_cast<std::size_t>(buffer.width * buffer.height));
  const bool big_endian = buffer.big_endian;
  forEachPoint(buffer, [&, &fx = x, &fy = y, &fz = z](const std::uint8_t* point) {
    cloud.points.push_back({static_cast<float>(valueAt(point, fx, big_endian)),
                            static_cast<float>(valueAt(point, fy, big_endian)),
                            static_cast<float>(valueAt(point, fz, big_endian)), 0.0F});
  });
  if (const std::optional<PointField> time = timeField(buffer)) readTimes(buffer, *time, cloud);
  return cloud;
}

}  // namespace kestrel
