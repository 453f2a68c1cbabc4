// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/messages/planar_scan_message.h"

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/messages/sensor_messages.h"

namespace kestrel {
namespace {

constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint8_t kClear = kestrel_slam::PlanarScan::CLEAR;
constexpr std::uint8_t kHit = kestrel_slam::PlanarScan::HIT;
constexpr std::uint8_t kNoReturn = kestrel_slam::PlanarScan::NO_RETURN;
constexpr std::uint8_t kPresumed = kestrel_slam::PlanarScan::PRESUMED;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Prefers a near hit to a farther hit, and any hit to a ray that only marks free space.
float nearer(float before, float range) {
  return std::isnan(before) ? range : std::min(before, range);
}

/// Throws if the value is infinite or only a part of it is absent.
bool isPresent(const Eigen::VectorXd& value, const char* name) {
  if (value.array().isNaN().all()) return false;
  if (value.allFinite()) return true;
  throw std::invalid_argument(std::string(name) + " is not finite");
}

void requireLengths(const kestrel_slam::PlanarScan& message) {
  const std::size_t rays = message.hit.size();
  if (message.end_x.size() == rays && message.end_y.size() == rays &&
      message.origin_x.size() == rays && message.origin_y.size() == rays) {
    return;
  }
  throw std::invalid_argument(
      "its arrays have different lengths: end_x " + std::to_string(message.end_x.size()) +
      ", end_y " + std::to_string(message.end_y.size()) + ", origin_x " +
      std::to_string(message.origin_x.size()) + ", origin_y " +
      std::to_string(message.origin_y.size()) + ", hit " + std::to_string(rays));
}

PlanarRay rayAt(const kestrel_slam::PlanarScan& message, std::size_t i) {
  PlanarRay ray{{message.origin_x[i], message.origin_y[i]},
                {message.end_x[i], message.end_y[i]},
                message.hit[i] == kHit};
  ray.no_return = message.hit[i] == kNoReturn;
  ray.presumed = message.hit[i] == kPresumed;
  if (ray.origin.allFinite() && ray.end.allFinite()) return ray;
  throw std::invalid_argument("ray " + std::to_string(i) + " is not finite");
}

ScanHeight heightOf(const kestrel_slam::PlanarScan& message) {
  const ScanHeight height{message.height, {message.height_slope_x, message.height_slope_y}};
  if (std::isfinite(height.base_m) && height.slope.allFinite()) return height;
  throw std::invalid_argument("height is not finite");
}

std::uint8_t kindOf(const PlanarRay& ray) {
  if (ray.hit) return kHit;
  return ray.no_return ? kNoReturn : ray.presumed ? kPresumed : kClear;
}

}  // namespace

kestrel_slam::PlanarScanPtr toPlanarScanMessage(const PlanarScan& scan, const std::string& frame,
                                                const ros::Time& stamp) {
  const auto message = boost::make_shared<kestrel_slam::PlanarScan>();
  message->header.stamp = stamp;
  message->header.frame_id = frame;
  message->source = scan.source;
  message->integrated_yaw = scan.integrated_yaw.value_or(kAbsent);
  const Eigen::Vector2d acceleration =
      scan.integrated_acceleration.value_or(Eigen::Vector2d::Constant(kAbsent));
  message->integrated_acceleration_x = acceleration.x();
  message->integrated_acceleration_y = acceleration.y();
  message->predicted_x = scan.predicted ? scan.predicted->x : kAbsent;
  message->predicted_y = scan.predicted ? scan.predicted->y : kAbsent;
  message->predicted_yaw = scan.predicted ? scan.predicted->yaw : kAbsent;
  message->height = scan.height.isKnown() ? scan.height.base_m : kNan;
  message->height_slope_x = scan.height.slope.x();
  message->height_slope_y = scan.height.slope.y();
  for (auto* array : {&message->origin_x, &message->origin_y, &message->end_x, &message->end_y}) {
    array->reserve(scan.rays.size());
  }
  message->hit.reserve(scan.rays.size());
  for (const PlanarRay& ray : scan.rays) {
    message->origin_x.push_back(ray.origin.x());
    message->origin_y.push_back(ray.origin.y());
    message->end_x.push_back(ray.end.x());
    message->end_y.push_back(ray.end.y());
    message->hit.push_back(kindOf(ray));
  }
  return message;
}

PlanarScan fromPlanarScanMessage(const kestrel_slam::PlanarScan& message) {
  requireLengths(message);
  PlanarScan scan;
  scan.stamp = scan.time = toSeconds(message.header.stamp);
  scan.source = message.source;
  const Eigen::Vector2d acceleration(message.integrated_acceleration_x,
                                     message.integrated_acceleration_y);
  const Eigen::Vector3d predicted(message.predicted_x, message.predicted_y, message.predicted_yaw);
  if (isPresent(Eigen::VectorXd::Constant(1, message.integrated_yaw), "integrated_yaw")) {
    scan.integrated_yaw = message.integrated_yaw;
  }
  if (isPresent(acceleration, "integrated_acceleration")) {
    scan.integrated_acceleration = acceleration;
  }
  if (isPresent(predicted, "predicted")) {
    scan.predicted = Pose2(predicted.x(), predicted.y(), predicted.z());
  }
  if (!std::isnan(message.height)) scan.height = heightOf(message);
  scan.rays.reserve(message.hit.size());
  for (std::size_t i = 0; i < message.hit.size(); ++i) scan.rays.push_back(rayAt(message, i));
  return scan;
}

sensor_msgs::LaserScanPtr toLaserScanView(const PlanarScan& scan, const std::string& frame,
                                          const ros::Time& stamp, double angle_increment,
                                          double range_max) {
  if (!(angle_increment > 0.0 && angle_increment <= kPi)) {
    throw std::invalid_argument("the angle increment of the view must lie between 0 and pi");
  }
  const auto bins = static_cast<std::size_t>(std::ceil(2.0 * kPi / angle_increment));
  const double step = 2.0 * kPi / static_cast<double>(bins);  // equal bins fill the full circle
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
