// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/series.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kestrel {
namespace {

constexpr double kSpeedWindow_s = 0.5;

}  // namespace

std::vector<std::size_t> minMaxIndices(const std::vector<double>& values, std::size_t max_points) {
  const std::size_t n = values.size();
  std::vector<std::size_t> indices;
  if (n <= max_points) {
    indices.resize(n);
    std::iota(indices.begin(), indices.end(), std::size_t{0});
    return indices;
  }
  const std::size_t stretches = (max_points - 2) / 2;
  const auto begin = values.begin();
  indices.push_back(0);
  for (std::size_t s = 0; s < stretches; ++s) {
    // Between the first and the last value, which are always selected.
    const auto first = static_cast<std::ptrdiff_t>(1 + s * (n - 2) / stretches);
    const auto last = static_cast<std::ptrdiff_t>(1 + (s + 1) * (n - 2) / stretches);
    const auto [low, high] = std::minmax_element(begin + first, begin + last);
    const auto a = static_cast<std::size_t>(std::min(low, high) - begin);
    const auto b = static_cast<std::size_t>(std::max(low, high) - begin);
    indices.push_back(a);
    if (b != a) indices.push_back(b);
  }
  indices.push_back(n - 1);
  return indices;
}

Speeds speedsOf(const std::vector<double>& times, const std::vector<Pose2>& poses) {
  Speeds speeds;
  std::size_t from = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    while (from + 1 < i && times[i] - times[from + 1] >= kSpeedWindow_s) ++from;
    const double dt = times[i] - times[from];
    const Pose2 motion = poses[from].inverse() * poses[i];
    speeds.linear_m_s.push_back(dt > 0.0 ? motion.distance() / dt : 0.0);
    speeds.angular_rad_s.push_back(dt > 0.0 ? motion.yaw / dt : 0.0);
  }
  return speeds;
}

}  // namespace kestrel
