// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/mean_shift.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "point_bins.h"

namespace kestrel {
namespace {

// The set of points within the radius changes at every step and never comes back, so that the shift
// ends by itself; this only bounds the work.
constexpr int kMaxSteps = 100;
/// Up to this number, all pairs of groups of points are compared: cheaper than bins.
constexpr std::size_t kFewPoints = 400;

template <int D>
using PointList = std::vector<Eigen::Matrix<double, D, 1>>;

/// What the climb before leaves to the next one, which is often near.
template <int D>
struct Climb {
  typename PointBins<D>::Neighbors neighbors;
  PointList<D> path;  ///< its places
  Eigen::Matrix<double, D, 1> mode;
  std::size_t density = 0;  ///< points near the mode
};

/// Shifts `start` to the mean of the points near it until it stays where it is. Where it comes to a
/// place of the climb before, it goes the same way.
template <int D>
Eigen::Matrix<double, D, 1> climbIn(const PointBins<D>& bins, const PointList<D>& points,
                                    Eigen::Matrix<double, D, 1> start, Climb<D>& last) {
  PointList<D> path;
  std::size_t count = 0;
  for (int step = 0; step < kMaxSteps; ++step) {
    if (std::find(last.path.begin(), last.path.end(), start) != last.path.end()) {
      path.insert(path.end(), last.path.begin(), last.path.end());
      last.path = std::move(path);
      return last.mode;
    }
    path.push_back(start);
    Eigen::Matrix<double, D, 1> sum = Eigen::Matrix<double, D, 1>::Zero();
    count = 0;
    bins.forEachNear(start, last.neighbors, [&](std::size_t i) {
      sum += points[i];
      ++count;
    });
    if (count == 0) break;
    const Eigen::Matrix<double, D, 1> mean = sum / static_cast<double>(count);
    if (mean == start) break;
    start = mean;
  }
  last.path = std::move(path);
  last.mode = start;
  last.density = count;
  return start;
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

/// Points and the box around them.
template <int D>
struct Group {
  std::vector<std::size_t> points;
  Eigen::Matrix<double, D, 1> low, high;

  Group(const PointList<D>& all, std::vector<std::size_t> numbers)
      : points(std::move(numbers)), low(all[points.front()]), high(low) {
    for (const std::size_t i : points) {
      low = low.cwiseMin(all[i]);
      high = high.cwiseMax(all[i]);
    }
  }
};

template <int D>
bool areNear(const PointList<D>& points, const Group<D>& a, const Group<D>& b, double distance) {
  constexpr double kRounding = 1.0 + 1e-9;
  const double apart = (a.low - b.high).cwiseMax(b.low - a.high).maxCoeff();
  if (apart > kRounding * distance) return false;
  for (const std::size_t i : a.points) {
    for (const std::size_t j : b.points) {
      if ((points[i] - points[j]).squaredNorm() <= distance * distance) return true;
    }
  }
  return false;
}

/// Joins the numbers of groups that are near to each other.
template <int D>
std::vector<std::size_t> joinGroups(const PointList<D>& points, const std::vector<Group<D>>& groups,
                                    double distance) {
  std::vector<std::size_t> parent = separate(groups.size());
  for (std::size_t a = 0; a < groups.size(); ++a) {
    for (std::size_t b = a + 1; b < groups.size(); ++b) {
      if (rootOf(parent, a) == rootOf(parent, b)) continue;
      if (areNear<D>(points, groups[a], groups[b], distance)) join(parent, a, b);
    }
  }
  return parent;
}

/// separateSets() of few points, most of which are near to the one before, as the returns of a
/// laser: only such pieces are compared.
template <int D>
std::vector<std::vector<std::size_t>> separatePieces(const PointList<D>& points, double distance) {
  std::vector<Group<D>> pieces;
  for (std::size_t first = 0, end = 0; first < points.size(); first = end) {
    do {
      ++end;
    } while (end < points.size() &&
             (points[end] - points[end - 1]).squaredNorm() <= distance * distance);
    std::vector<std::size_t> piece(end - first);
    std::iota(piece.begin(), piece.end(), first);
    pieces.emplace_back(points, std::move(piece));
  }
  std::vector<std::size_t> parent = joinGroups<D>(points, pieces, distance);
  std::vector<std::vector<std::size_t>> sets(pieces.size());
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    std::vector<std::size_t>& set = sets[rootOf(parent, p)];
    set.insert(set.end(), pieces[p].points.begin(), pieces[p].points.end());
  }
  return sets;
}

/// Sets of points that are farther than `distance` from all others.
template <int D>
std::vector<std::vector<std::size_t>> separateSets(const PointList<D>& points, double distance) {
  if (points.size() <= kFewPoints) return separatePieces<D>(points, distance);
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

/// True if no two points of the set are farther from each other than `distance`. May be false for
/// sets that are nearly as large.
template <int D>
bool isSmall(const PointList<D>& points, const std::vector<std::size_t>& set,
             const Eigen::Matrix<double, D, 1>& mean, double distance) {
  Eigen::Matrix<double, D, 1> low = mean, high = mean;
  double radius2 = 0.0;
  for (const std::size_t i : set) {
    low = low.cwiseMin(points[i]);
    high = high.cwiseMax(points[i]);
    radius2 = std::max(radius2, (points[i] - mean).squaredNorm());
  }
  return 4.0 * radius2 < distance * distance || (high - low).squaredNorm() < distance * distance;
}

/// A small set that is far from all other points has one mode, its mean, which every point reaches
/// with the first step. The points of other sets climb.
template <int D>
Modes<D> findModes(const PointList<D>& points, double bandwidth) {
  constexpr double kApart = 1.5;     // bandwidths; then no point of another set is near the mean
  std::optional<PointBins<D>> bins;  // most scans need none
  Climb<D> last;
  Modes<D> modes{points, std::vector<std::size_t>(points.size())};
  for (const auto& set : separateSets<D>(points, kApart * bandwidth)) {
    if (set.empty()) continue;
    const Eigen::Matrix<double, D, 1> mean = meanOf<D>(points, set);
    const bool is_small = isSmall<D>(points, set, mean, bandwidth);
    if (!is_small && !bins) bins.emplace(points, bandwidth);
    for (const std::size_t i : set) {
      modes.of_point[i] = is_small ? mean : climbIn<D>(*bins, points, points[i], last);
      modes.density[i] = is_small ? set.size() : last.density;
    }
  }
  return modes;
}

/// Joins the numbers of modes that are near to each other. Most modes are equal to the one before.
template <int D>
std::vector<std::size_t> joinModes(const PointList<D>& modes, double distance) {
  std::vector<std::size_t> parent = separate(modes.size());
  std::vector<std::size_t> different;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (i > 0 && modes[i] == modes[i - 1]) {
      join(parent, i, i - 1);
    } else {
      different.push_back(i);
    }
  }
  if (modes.size() > kFewPoints) {
    const PointBins<D> bins(modes, distance);
    for (const std::size_t i : different) {
      bins.forEachNear(modes[i], [&](std::size_t j) { join(parent, i, j); });
    }
    return parent;
  }
  for (const std::size_t i : different) {
    for (const std::size_t j : different) {
      if (j >= i) break;
      if ((modes[i] - modes[j]).squaredNorm() <= distance * distance) join(parent, i, j);
    }
  }
  return parent;
}

/// Joins the numbers of clusters that have points near to each other.
template <int D>
std::vector<std::size_t> joinClusters(const PointList<D>& points,
                                      const std::vector<PointCluster<D>>& clusters, double gap) {
  if (points.size() <= kFewPoints) {
    std::vector<Group<D>> groups;
    for (const PointCluster<D>& cluster : clusters) groups.emplace_back(points, cluster.points);
    return joinGroups<D>(points, groups, gap);
  }
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
  return parent;
}

}  // namespace

template <int D>
std::vector<PointCluster<D>> meanShift(const PointList<D>& points, double bandwidth) {
  const auto [modes, density] = findModes<D>(points, bandwidth);
  std::vector<std::size_t> parent = joinModes<D>(modes, 0.5 * bandwidth);
  std::vector<PointCluster<D>> clusters;
  std::vector<std::size_t> cluster_of(points.size()), size(points.size(), 0), best;
  for (std::size_t i = 0; i < points.size(); ++i) ++size[rootOf(parent, i)];
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t root = rootOf(parent, i);
    if (root == i) {
      cluster_of[i] = clusters.size();
      clusters.push_back({modes[i], {}});
      clusters.back().points.reserve(size[root]);
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
  Climb<D> last;
  return climbIn<D>(PointBins<D>(points, bandwidth), points, start, last);
}

template <int D>
std::vector<PointCluster<D>> joinConnected(const PointList<D>& points,
                                           std::vector<PointCluster<D>> clusters, double gap) {
  std::vector<std::size_t> parent = joinClusters<D>(points, clusters, gap);
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
