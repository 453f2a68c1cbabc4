// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// One value of every point of a packed cloud. `type` has the numbers of sensor_msgs/PointField.
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
  std::size_t offset = 0;  ///< bytes from the point's start
  int type = kFloat32;
};

/// Points as bytes, row by row, as messages and files hold them. Does not own the bytes.
struct PointBuffer {
  std::vector<PointField> fields;
  std::uint64_t width = 0;       ///< points in a row
  std::uint64_t height = 1;      ///< rows
  std::uint64_t point_step = 0;  ///< bytes from point to point
  std::uint64_t row_step = 0;    ///< bytes from row to row
  bool big_endian = false;
  const std::uint8_t* data = nullptr;
  std::uint64_t size = 0;  ///< bytes at `data`; there may be more than the points need
};

/// Unpacks `x`, `y`, `z` (float32 or float64) and, where there is one, the points' time:
/// `time`, `t`, `timestamp`, `time_offset` or `offset_time`, as float in s, as integer of 32 bits
/// in ns, as float64 also as absolute time in s or ns. Without one, all times are 0.
///
/// Throws std::invalid_argument that names what is wrong: fields that are missing (and those there
/// are), types that are unsupported, no points, fewer bytes than promised.
PointCloud unpackPoints(const PointBuffer& buffer, double stamp);

}  // namespace kestrel
