// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/mean_shift.h"

#include <algorithm>
#include <utility>

#include "point_bins.h"

namespace kestrel {
namespace {

// The set of points within the radius changes at every step and never comes back, so that the shift
// ends by itself; this only bounds the work.
constexpr int kMaxSteps = 100;

template <int D>
using PointList = std::vector<Eigen::Matrix<double, D, 1>>;

/// Shifts `start` to the mean of the points near it until it stays where it is.
template <int D>
Eigen::Matrix<double, D, 1> climbIn(const PointBins<D>& bins, const PointList<D>& points,
                                    Eigen::Matrix<double, D, 1> start) {
  for (int step = 0; step < kMaxSteps; ++step) {
    Eigen::Matrix<double, D, 1> sum = Eigen::Matrix<double, D, 1>::Zero();
    std::size_t count = 0;
    bins.forEachNear(start, [&](std::size_t i) {
      sum += points[i];
      ++count;
    });
    if (count == 0) return start;
    const Eigen::Matrix<double, D, 1> mean = sum / static_cast<double>(count);
    if (mean == start) return start;
    start = mean;
  }
  return start;
}

template <int D>
std::size_t countNear(const PointBins<D>& bins, const Eigen::Matrix<double, D, 1>& center) {
  std::size_t count = 0;
  bins.forEachNear(center, [&](std::size_t) { ++count; });
  return count;
}

/// The first of a set of joined numbers.
std::size_t rootOf(std::vector<std::size_t>& parent, std::size_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

void join(std::vector<std::size_t>& parent, std::size_t a, std::size_t b) {
  a = rootOf(parent, a), b = rootOf(parent, b);
  parent[std::max(a, b)] = std::min(a, b);
}

std::vector<std::size_t> separate(std::size_t count) {
  std::vector<std::size_t> parent(count);
  for (std::size_t i = 0; i < count; ++i) parent[i] = i;
  return parent;
}

template <int D>
struct Modes {
  PointList<D> of_point;
  std::vector<std::size_t> density;
};

/// Sets of points that are farther than `distance` from all others.
template <int D>
std::vector<std::vector<std::size_t>> separateSets(const PointList<D>& points, double distance) {
  std::vector<std::size_t> parent = separate(points.size());
  const PointBins<D> bins(points, distance);
  for (std::size_t i = 0; i < points.size(); ++i) {
    bins.forEachNear(points[i], [&](std::size_t j) {
      if (j > i) join(parent, i, j);
    });
  }
  std::vector<std::vector<std::size_t>> sets(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) sets[rootOf(parent, i)].push_back(i);
  return sets;
}

template <int D>
Eigen::Matrix<double, D, 1> meanOf(const PointList<D>& points,
                                   const std::vector<std::size_t>& set) {
  Eigen::Matrix<double, D, 1> sum = Eigen::Matrix<double, D, 1>::Zero();
  for (const std::size_t i : set) sum += points[i];
  return sum / static_cast<double>(set.size());
}

/// A small set that is far from all other points has one mode, its mean, which every point reaches
/// with the first step. The points of other sets climb.
template <int D>
Modes<D> findModes(const PointList<D>& points, double bandwidth) {
  constexpr double kHalf = 0.5;
  const PointBins<D> bins(points, bandwidth);
  Modes<D> modes{points, std::vector<std::size_t>(points.size())};
  for (const auto& set : separateSets<D>(points, (1.0 + kHalf) * bandwidth)) {
    if (set.empty()) continue;
    const Eigen::Matrix<double, D, 1> mean = meanOf<D>(points, set);
    const bool is_small = std::all_of(set.begin(), set.end(), [&](std::size_t i) {
      return (points[i] - mean).norm() < kHalf * bandwidth;
    });
    for (const std::size_t i : set) {
      modes.of_point[i] = is_small ? mean : climbIn<D>(bins, points, points[i]);
      modes.density[i] = is_small ? set.size() : countNear<D>(bins, modes.of_point[i]);
    }
  }
  return modes;
}

}  // namespace

template <int D>
std::vector<PointCluster<D>> meanShift(const PointList<D>& points, double bandwidth) {
  const auto [modes, density] = findModes<D>(points, bandwidth);
  std::vector<std::size_t> parent = separate(points.size());
  const PointBins<D> mode_bins(modes, 0.5 * bandwidth);
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (i > 0 && modes[i] == modes[i - 1]) {
      join(parent, i, i - 1);
      continue;
    }
    mode_bins.forEachNear(modes[i], [&, i = i](std::size_t j) { join(parent, i, j); });
  }
  std::vector<PointCluster<D>> clusters;
  std::vector<std::size_t> cluster_of(points.size()), best;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t root = rootOf(parent, i);
    if (root == i) {
      cluster_of[i] = clusters.size();
      clusters.push_back({modes[i], {}});
      best.push_back(density[i]);
    }
    const std::size_t c = cluster_of[root];
    clusters[c].points.push_back(i);
    if (density[i] <= best[c]) continue;
    best[c] = density[i];
    clusters[c].mode = modes[i];
  }
  return clusters;
}

template <int D>
Eigen::Matrix<double, D, 1> climb(const PointList<D>& points, double bandwidth,
                                  Eigen::Matrix<double, D, 1> start) {
  return climbIn<D>(PointBins<D>(points, bandwidth), points, start);
}

template <int D>
std::vector<PointCluster<D>> joinConnected(const PointList<D>& points,
                                           std::vector<PointCluster<D>> clusters, double gap) {
  std::vector<std::size_t> cluster_of(points.size());
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    for (const std::size_t i : clusters[c].points) cluster_of[i] = c;
  }
  std::vector<std::size_t> parent = separate(clusters.size());
  const PointBins<D> bins(points, gap);
  for (std::size_t i = 0; i < points.size(); ++i) {
    bins.forEachNear(points[i], [&](std::size_t j) {
      if (cluster_of[i] != cluster_of[j]) join(parent, cluster_of[i], cluster_of[j]);
    });
  }
  std::vector<PointCluster<D>> joined;
  std::vector<std::size_t> index_of(clusters.size());
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    const std::size_t root = rootOf(parent, c);
    if (root == c) {
      index_of[c] = joined.size();
      joined.push_back(std::move(clusters[c]));
      continue;
    }
    PointCluster<D>& target = joined[index_of[root]];
    target.points.insert(target.points.end(), clusters[c].points.begin(), clusters[c].points.end());
    std::sort(target.points.begin(), target.points.end());
    target.mode.setZero();
    for (const std::size_t i : target.points) target.mode += points[i];
    target.mode /= static_cast<double>(target.points.size());
  }
  return joined;
}

template std::vector<PointCluster<2>> meanShift<2>(const PointList<2>&, double);
template std::vector<PointCluster<3>> meanShift<3>(const PointList<3>&, double);
template Eigen::Vector2d climb<2>(const PointList<2>&, double, Eigen::Vector2d);
template Eigen::Vector3d climb<3>(const PointList<3>&, double, Eigen::Vector3d);
template std::vector<PointCluster<2>> joinConnected<2>(const PointList<2>&,
                                                       std::vector<PointCluster<2>>, double);
template std::vector<PointCluster<3>> joinConnected<3>(const PointList<3>&,
                                                       std::vector<PointCluster<3>>, double);

}  // namespace kestrel
