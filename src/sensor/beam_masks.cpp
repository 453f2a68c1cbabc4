// SPDX-License-Identifier: BSD-3-Clause
#include "beam_masks.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "kestrel_slam/geometry/angles.h"
#include "pair_list.h"

namespace kestrel {
namespace {

constexpr std::size_t kMinMirrorBeams = 3;

bool contains(const std::vector<AngleRange>& ranges, double angle) {
  return std::any_of(ranges.begin(), ranges.end(), [angle](const AngleRange& range) {
    return angle >= range.from && angle <= range.to;
  });
}

double angleOf(const LaserScan& scan, std::size_t i) {
  return scan.angle_min + static_cast<double>(i) * scan.angle_increment;
}

[[noreturn]] void refuse(const std::string& text) {
  throw std::invalid_argument("'" + text +
                              "' is no list of angles: write from:to, from:to in degrees, with "
                              "from < to, for example -135:-110, 110:135");
}

}  // namespace

std::vector<AngleRange> parseAngleRanges(const std::string& text) {
  const auto pairs = parsePairs(text);
  if (!pairs) refuse(text);
  std::vector<AngleRange> ranges;
  for (const auto& [from, to] : *pairs) {
    if (!(from < to)) refuse(text);
    ranges.push_back({degToRad(from), degToRad(to)});
  }
  return ranges;
}

std::vector<bool> maskOf(const LaserScan& scan, const std::vector<AngleRange>& ignored,
                         const std::vector<AngleRange>& mirror) {
  if (ignored.empty() && mirror.empty()) return {};
  std::vector<bool> mask(scan.ranges.size());
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const double angle = angleOf(scan, i);
    mask[i] = contains(ignored, angle) || contains(mirror, angle);
  }
  return mask;
}

std::optional<double> mirrorHeight(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser,
                                   const Eigen::Quaterniond& stabilized_R_base,
                                   const std::vector<AngleRange>& mirror,
                                   const ProjectorConfig& config) {
  if (mirror.empty()) return std::nullopt;
  std::vector<double> heights;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double range = scan.ranges[i];
    const bool returned = range > std::max(config.mirror_distance_m, scan.range_min) &&
                          range < config.beams.max_range_m;
    if (!returned || !contains(mirror, angleOf(scan, i))) continue;
    const double angle = angleOf(scan, i);
    const Eigen::Vector3d at_mirror =
        base_T_laser *
        (config.mirror_distance_m * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0));
    const Eigen::Vector3d on_floor =
        at_mirror - (range - config.mirror_distance_m) * Eigen::Vector3d::UnitZ();
    heights.push_back(-(stabilized_R_base * on_floor).z());
  }
  if (heights.size() < kMinMirrorBeams) return std::nullopt;
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  return *middle > 0.0 ? std::optional(*middle) : std::nullopt;
}

}  // namespace kestrel
