// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/messages/planar_scan_message.h"

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

/// One point of the message as it lies in memory.
struct Point {
  float x, y, z, hit, origin_x, origin_y, heading, speed_x, speed_y, predicted_x, predicted_y,
      predicted_yaw;
};
constexpr const char* kFields[] = {"x",        "y",           "z",           "hit",
                                   "origin_x", "origin_y",    "heading",     "speed_x",
                                   "speed_y",  "predicted_x", "predicted_y", "predicted_yaw"};
constexpr std::size_t kFieldCount = sizeof kFields / sizeof kFields[0];
static_assert(sizeof(Point) == kFieldCount * sizeof(float));

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kHitThreshold = 0.5F;  // `hit` is 0 or 1

/// Where the fields that are read lie in a point, bytes.
struct Offsets {
  std::size_t x, y, hit, origin_x, origin_y, heading;
};

std::size_t offsetOf(const PointCloud2& message, const std::string& name) {
  for (const PointField& field : message.fields) {
    if (field.name != name) continue;
    if (field.datatype != PointField::FLOAT32 || field.count > 1) {
      throw std::invalid_argument("its field '" + name + "' is not a single float32");
    }
    if (static_cast<std::size_t>(field.offset) + sizeof(float) > message.point_step) {
      throw std::invalid_argument("its field '" + name + "' lies beyond point_step " +
                                  std::to_string(message.point_step));
    }
    return field.offset;
  }
  throw std::invalid_argument("it has no field '" + name +
                              "'; planar scans come from the scan projector");
}

/// The payload has to hold what the sizes promise.
void requirePayload(const PointCloud2& message) {
  if (message.width == 0 || message.height == 0) return;
  const std::size_t row = static_cast<std::size_t>(message.width) * message.point_step;
  if (message.height > 1 && message.row_step < row) {
    throw std::invalid_argument("its row_step " + std::to_string(message.row_step) +
                                " is less than the " + std::to_string(row) + " bytes of a row");
  }
  const std::size_t promised =
      static_cast<std::size_t>(message.height - 1) * message.row_step + row;
  if (message.data.size() < promised) {
    throw std::invalid_argument("it has " + std::to_string(message.data.size()) +
                                " bytes of data, its sizes promise " + std::to_string(promised));
  }
}

Offsets offsetsOf(const PointCloud2& message) {
  return {offsetOf(message, "x"),        offsetOf(message, "y"),
          offsetOf(message, "hit"),      offsetOf(message, "origin_x"),
          offsetOf(message, "origin_y"), offsetOf(message, "heading")};
}

/// Messages need not be aligned.
float floatAt(const std::uint8_t* bytes) {
  float value = 0.0F;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

PlanarRay rayAt(const std::uint8_t* point, const Offsets& offsets) {
  const Eigen::Vector2f origin(floatAt(point + offsets.origin_x),
                               floatAt(point + offsets.origin_y));
  const Eigen::Vector2f end(floatAt(point + offsets.x), floatAt(point + offsets.y));
  const float hit = floatAt(point + offsets.hit);
  if (!origin.allFinite() || !end.allFinite() || !std::isfinite(hit)) {
    throw std::invalid_argument("it has a point that is not finite");
  }
  return {origin, end, hit > kHitThreshold};
}

/// NaN says that there is no gyro.
std::optional<double> headingAt(const std::uint8_t* point, const Offsets& offsets) {
  const float heading = floatAt(point + offsets.heading);
  if (std::isnan(heading)) return std::nullopt;
  if (std::isinf(heading)) throw std::invalid_argument("its heading is infinite");
  return static_cast<double>(heading);
}

void describeFields(PointCloud2& message) {
  message.fields.resize(kFieldCount);
  for (std::size_t i = 0; i < kFieldCount; ++i) {
    message.fields[i].name = kFields[i];
    message.fields[i].offset = static_cast<std::uint32_t>(i * sizeof(float));
    message.fields[i].datatype = PointField::FLOAT32;
    message.fields[i].count = 1;
  }
}

/// One number of the whole scan, that stands in all of its points. NaN where the message has no
/// such field: other programs may not know it.
double sharedValue(const PointCloud2& message, const std::string& name) {
  const bool named = std::any_of(message.fields.begin(), message.fields.end(),
                                 [&](const PointField& field) { return field.name == name; });
  if (message.width == 0 || message.height == 0 || !named) return static_cast<double>(kNan);
  return static_cast<double>(floatAt(message.data.data() + offsetOf(message, name)));
}

std::optional<Eigen::Vector2d> speedOf(const PointCloud2& message) {
  const Eigen::Vector2d speed(sharedValue(message, "speed_x"), sharedValue(message, "speed_y"));
  return speed.allFinite() ? std::optional(speed) : std::nullopt;
}

std::optional<Pose2> predictedOf(const PointCloud2& message) {
  const Pose2 pose(sharedValue(message, "predicted_x"), sharedValue(message, "predicted_y"),
                   sharedValue(message, "predicted_yaw"));
  return pose.isFinite() ? std::optional(pose) : std::nullopt;
}

/// A nearer return hides a farther one, and any return what only clears.
float nearer(float before, float range) {
  return std::isnan(before) ? range : std::min(before, range);
}

}  // namespace

sensor_msgs::PointCloud2Ptr toPlanarScanMessage(const PlanarScan& scan, const std::string& frame,
                                                const ros::Time& stamp) {
  const auto message = boost::make_shared<PointCloud2>();
  message->header.frame_id = frame;
  message->header.stamp = stamp;
  describeFields(*message);
  message->height = 1;
  message->width = static_cast<std::uint32_t>(scan.rays.size());
  message->point_step = sizeof(Point);
  message->row_step = message->width * message->point_step;
  message->is_dense = true;
  message->data.resize(scan.rays.size() * sizeof(Point));
  const float heading = scan.integrated_yaw ? static_cast<float>(*scan.integrated_yaw) : kNan;
  const Eigen::Vector2f speed =
      scan.integrated_acceleration.value_or(Eigen::Vector2d(kNan, kNan)).cast<float>();
  Eigen::Vector3f predicted = Eigen::Vector3f::Constant(kNan);
  if (scan.predicted) {
    predicted =
        Eigen::Vector3d(scan.predicted->x, scan.predicted->y, scan.predicted->yaw).cast<float>();
  }
  std::uint8_t* place = message->data.data();
  for (const PlanarRay& ray : scan.rays) {
    const Point point{ray.end.x(),    ray.end.y(),    0.0F,          ray.hit ? 1.0F : 0.0F,
                      ray.origin.x(), ray.origin.y(), heading,       speed.x(),
                      speed.y(),      predicted.x(),  predicted.y(), predicted.z()};
    std::memcpy(place, &point, sizeof point);
    place += sizeof point;
  }
  return message;
}

PlanarScan fromPlanarScanMessage(const sensor_msgs::PointCloud2& message) {
  if (message.is_bigendian) throw std::invalid_argument("its data are big-endian");
  const Offsets offsets = offsetsOf(message);
  requirePayload(message);
  PlanarScan scan;
  scan.stamp = scan.time = message.header.stamp.toSec();
  scan.integrated_acceleration = speedOf(message);
  scan.predicted = predictedOf(message);
  scan.rays.reserve(static_cast<std::size_t>(message.width) * message.height);
  for (std::size_t row = 0; row < message.height; ++row) {
    const std::uint8_t* point = message.data.data() + row * message.row_step;
    for (std::size_t column = 0; column < message.width; ++column, point += message.point_step) {
      if (scan.rays.empty()) scan.integrated_yaw = headingAt(point, offsets);
      scan.rays.push_back(rayAt(point, offsets));
    }
  }
  return scan;
}

sensor_msgs::LaserScanPtr toLaserScanView(const PlanarScan& scan, const std::string& frame,
                                          const ros::Time& stamp, double angle_increment,
                                          double range_max) {
  if (!(angle_increment > 0.0 && angle_increment <= kPi)) {
    throw std::invalid_argument("the angle increment of the view must lie between 0 and pi");
  }
  const auto bins = static_cast<std::size_t>(std::ceil(2.0 * kPi / angle_increment));
  const double step = 2.0 * kPi / static_cast<double>(bins);  // the bins fill the turn evenly
  const auto message = boost::make_shared<sensor_msgs::LaserScan>();
  message->header.frame_id = frame;
  message->header.stamp = stamp;
  message->angle_min = static_cast<float>(-kPi);
  message->angle_max = static_cast<float>(kPi - step);
  message->angle_increment = static_cast<float>(step);
  message->range_max = static_cast<float>(range_max);
  message->ranges.assign(bins, kNan);
  for (const PlanarRay& ray : scan.rays) {
    const double angle =
        std::atan2(static_cast<double>(ray.end.y()), static_cast<double>(ray.end.x()));
    const auto bin = static_cast<std::size_t>(std::lround((angle + kPi) / step)) % bins;
    const float range = ray.end.norm();
    const bool visible = ray.hit && range <= message->range_max;
    message->ranges[bin] = nearer(message->ranges[bin], visible ? range : kInfinity);
  }
  return message;
}

}  // namespace kestrel
