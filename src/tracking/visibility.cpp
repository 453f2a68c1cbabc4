// SPDX-License-Identifier: BSD-3-Clause
#include "visibility.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "sectors.h"

namespace kestrel {
namespace {

constexpr double kOccluderGap = 0.2;   // m; an occluder is at least this much nearer
constexpr double kBesideBeams = 1.5;   // to the beam beside, from anywhere between two beams
constexpr double kNearestRange = 0.1;  // m; nearer objects surround the sensor

constexpr double kRounding = 1e-6;  // bins; a bearing so near to a border may be in either bin

/// As std::floor, which is a call of a function.
int floorOf(double value) {
  const int truncated = static_cast<int>(value);
  return truncated - static_cast<int>(value < static_cast<double>(truncated));
}

/// Tangent of the angle between two directions; infinite from a quarter of a turn on.
float turnBetween(const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
  const float dot = a.dot(b);
  return dot > 0.0F ? std::abs(a.x() * b.y() - a.y() * b.x()) / dot
                    : std::numeric_limits<float>::infinity();
}

float medianOf(std::vector<float> values) {
  if (values.empty()) return 0.0F;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

int Visibility::binOf(double bearing) {
  constexpr double kPerRadian = kBins / (2.0 * kPi);
  int bin = floorOf((bearing + kPi) * kPerRadian);
  while (bin < 0) bin += kBins;
  while (bin >= kBins) bin -= kBins;
  return bin;
}

Visibility::Visibility(const std::vector<GridRay<2>>& rays)
    : reach_(kBins, -1.0F), returns_(kBins, -1.0F) {
  if (!rays.empty()) sensor_ = rays[rays.size() / 2].origin.cast<double>();
  static const Sectors sectors(kBins);
  std::vector<float> turns;
  turns.reserve(rays.size());
  Eigen::Vector2f last = Eigen::Vector2f::Zero();
  int sector = 0;
  for (const GridRay<2>& ray : rays) {
    const Eigen::Vector2f along = ray.end - ray.origin;
    const float length = along.norm();
    if (!std::isfinite(length)) continue;
    if (&ray != &rays.front()) turns.push_back(turnBetween(last, along));
    last = along;
    sector = sectors.of(along, sector);
    const auto bin = static_cast<std::size_t>(sector);
    reach_[bin] = std::max(reach_[bin], length);
    if (ray.hit) returns_[bin] = std::max(returns_[bin], length);
  }
  beam_step_ = static_cast<double>(std::atan(medianOf(std::move(turns))));
}

double Visibility::bearingOf(const Eigen::Vector2d& point) const {
  return std::atan2(point.y() - sensor_.y(), point.x() - sensor_.x());
}

bool Visibility::isHiddenAt(double bearing, double range) const {
  const float reach = reach_[static_cast<std::size_t>(binOf(bearing))];
  return reach >= 0.0F && static_cast<double>(reach) < range - kOccluderGap;
}

bool Visibility::isPassed(const std::vector<float>& reach_of, const Eigen::Vector2d& point,
                          double width) const {
  const double range = std::max(rangeOf(point), kNearestRange), middle = bearingOf(point);
  const double half = 0.5 * width / range + kBesideBeams * beam_step_;
  const int first = floorOf(-half / (2.0 * kPi) * kBins);
  bool measured = false;
  for (int i = first; i <= -first; ++i) {
    const float reach = reach_of[static_cast<std::size_t>(binOf(middle + i * 2.0 * kPi / kBins))];
    if (reach < 0.0F) continue;
    if (static_cast<double>(reach) < range + 0.5 * width) return false;
    measured = true;
  }
  return measured;
}

bool Visibility::isCut(const std::vector<Eigen::Vector2d>& points) const {
  const double middle = bearingOf(points.front());
  double low = 0.0, high = 0.0, range = rangeOf(points.front());
  for (const Eigen::Vector2d& point : points) {
    const double offset = normalizeAngle(bearingOf(point) - middle);
    low = std::min(low, offset);
    high = std::max(high, offset);
    range = std::min(range, rangeOf(point));
  }
  const double beside = 2.0 * std::max(beam_step_, 2.0 * kPi / kBins);
  return isHiddenAt(middle + low - beside, range) || isHiddenAt(middle + high + beside, range);
}

Visibility::Beams Visibility::countIn(int first, int count, double range) const {
  // The smallest float that is not below the range, because float is compared with float.
  auto needed = static_cast<float>(std::max(range, 0.0));
  if (static_cast<double>(needed) < range) {
    needed = std::nextafter(needed, std::numeric_limits<float>::infinity());
  }
  Beams beams;
  while (count > 0) {
    const int last = std::min(first + count, kBins);
    for (int bin = first; bin < last; ++bin) {
      const float reach = reach_[static_cast<std::size_t>(bin)];
      beams.measured += static_cast<int>(reach >= 0.0F);
      beams.visible += static_cast<int>(reach >= needed);
    }
    count -= last - first;
    first = 0;
  }
  return beams;
}

double Visibility::visibleShare(const Eigen::Vector2d& center, double width) const {
  const Eigen::Vector2d offset = center - sensor_;
  const double range = std::max(offset.norm(), kNearestRange);
  const double half = std::atan2(0.5 * width, range);
  const int first = floorOf(-half / (2.0 * kPi) * kBins);
  const int count = 1 - 2 * first;
  const double bearing = std::atan2(offset.y(), offset.x());
  // A beam that ends within the object hits the object itself.
  const double needed = range - width;
  const double place = (bearing + kPi) * kBins / (2.0 * kPi);
  Beams beams;
  if (std::abs(place - floorOf(place + 0.5)) > kRounding) {
    beams = countIn(binOf(bearing + first * 2.0 * kPi / kBins), count, needed);
  } else {
    for (int i = 0; i < count; ++i) {
      const Beams one = countIn(binOf(bearing + (first + i) * 2.0 * kPi / kBins), 1, needed);
      beams.measured += one.measured;
      beams.visible += one.visible;
    }
  }
  // Bins without a beam lie between two beams, or outside of the field of view.
  const double bins_per_beam = std::max(1.0, beam_step_ * kBins / (2.0 * kPi));
  const double expected = static_cast<double>(count) / bins_per_beam;
  return beams.visible > 0 ? beams.visible / std::max(expected, static_cast<double>(beams.measured))
                           : 0.0;
}

}  // namespace kestrel
