// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/point_times.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

namespace kestrel {
namespace {

constexpr double kUnits[] = {1.0, 1e-3, 1e-6, 1e-9};  // s
// A packet of a lidar takes at least about 1 ms, a sweep at most 1 s.
constexpr double kShortest = 4e-4, kLongest = 2.0;  // s
constexpr double kUsual = 0.1;                      // s

/// Organized clouds mark missing returns with NaN or zeros. Their times are not valid either.
bool isReturn(const PointCloud::Point& point) {
  return std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z) &&
         (point.x != 0.0F || point.y != 0.0F || point.z != 0.0F);
}

struct Span {
  double first = std::numeric_limits<double>::infinity();
  double last = -std::numeric_limits<double>::infinity();

  double length() const { return last - first; }
  double farthest() const { return std::max(std::abs(first), std::abs(last)); }
};

template <typename Visit>
void forEachTime(const std::vector<double>& values, PointCloud& cloud, Visit visit) {
  for (std::size_t i = 0; i < values.size() && i < cloud.points.size(); ++i) {
    if (isReturn(cloud.points[i]) && std::isfinite(values[i])) visit(values[i], cloud.points[i]);
  }
}

bool isSweep(double seconds) { return seconds >= kShortest && seconds <= kLongest; }

/// True if the times are near the stamp of the cloud: one sweep before or after it.
bool isNear(const Span& span, double unit, double zero) {
  return std::abs(unit * span.first - zero) <= kLongest &&
         std::abs(unit * span.last - zero) <= kLongest;
}

/// The unit of the numbers, s; nothing if no unit is possible.
std::optional<double> unitOf(const Span& span, double usual_unit, double stamp) {
  for (const double unit : kUnits) {  // absolute times also tell their unit
    if (std::abs(stamp) > kLongest && isNear(span, unit, stamp)) return unit;
  }
  // The farthest time from 0 also shows the unit if all returns were measured at nearly one time.
  for (const double duration : {span.length(), span.farthest()}) {
    if (isSweep(usual_unit * duration)) return usual_unit;
  }
  std::optional<double> best;
  const auto distance = [&](double unit) {
    return std::abs(std::log(unit * span.length() / kUsual));
  };
  for (const double unit : kUnits) {
    if (!isSweep(unit * span.length())) continue;
    if (!best || distance(unit) < distance(*best)) best = unit;
  }
  return best;
}

std::string constantText(double value) {
  char text[120];
  std::snprintf(text, sizeof text,
                "the points of a cloud all have the same time (%g): their times are not used",
                value);
  return text;
}

std::string noUnitText(const Span& span) {
  char text[160];
  std::snprintf(text, sizeof text,
                "the times of the points of a cloud span %g, which is no sweep in s, ms, us or ns: "
                "they are not used",
                span.length());
  return text;
}

}  // namespace

bool isPointTime(const std::string& name) {
  static const char* const kNames[] = {"time",        "t",           "timestamp",
                                       "time_offset", "offset_time", "time_stamp"};
  return std::find(std::begin(kNames), std::end(kNames), name) != std::end(kNames);
}

void setPointTimes(const std::vector<double>& values, double usual_unit, PointCloud& cloud) {
  Span span;
  std::size_t count = 0;
  forEachTime(values, cloud, [&](double value, const PointCloud::Point& /*point*/) {
    span.first = std::min(span.first, value);
    span.last = std::max(span.last, value);
    ++count;
  });
  if (count == 0) return;
  if (count > 1 && span.length() == 0.0) {
    cloud.time_problem = constantText(span.first);
    return;
  }
  const std::optional<double> unit = unitOf(span, usual_unit, cloud.stamp);
  if (!unit) {
    cloud.time_problem = noUnitText(span);
    return;
  }
  const double zero = isNear(span, *unit, 0.0)           ? 0.0
                      : isNear(span, *unit, cloud.stamp) ? cloud.stamp
                                                         : *unit * span.first;
  forEachTime(values, cloud, [&](double value, PointCloud::Point& point) {
    point.time = static_cast<float>(*unit * value - zero);
  });
}

}  // namespace kestrel
