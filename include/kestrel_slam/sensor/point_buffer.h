// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// A field of the points of a packed cloud. `type` uses the numbers of sensor_msgs/PointField.
struct PointField {
  enum Type : int {
    kInt8 = 1,
    kUint8 = 2,
    kInt16 = 3,
    kUint16 = 4,
    kInt32 = 5,
    kUint32 = 6,
    kFloat32 = 7,
    kFloat64 = 8
  };
  std::string name;
  std::size_t offset = 0;  ///< bytes from the start of the point
  int type = kFloat32;
};

/// Packed points, row by row, as in messages and files. Does not own the bytes.
struct PointBuffer {
  std::vector<PointField> fields;
  std::uint64_t width = 0;       ///< points per row
  std::uint64_t height = 1;      ///< rows
  std::uint64_t point_step = 0;  ///< bytes per point
  std::uint64_t row_step = 0;    ///< bytes per row
  bool big_endian = false;
  const std::uint8_t* data = nullptr;
  std::uint64_t size = 0;  ///< bytes at `data`; may be more than the points need
};

/// Unpacks `x`, `y`, `z` (float32 or float64) and, if there is one, the time of each point (see
/// setPointTimes()). Without a time field all times are 0. `stamp`: of the cloud, s.
///
/// Throws std::invalid_argument with the reason: missing fields, unsupported types, no points, or
/// too few bytes.
PointCloud unpackPoints(const PointBuffer& buffer, double stamp);

}  // namespace kestrel
