// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace kestrel {

/// Points that belong together.
template <int D>
struct PointCluster {
  Eigen::Matrix<double, D, 1> mode;  ///< local maximum of the density of points
  std::vector<std::size_t> points;   ///< indices, ascending
};

/// Mean-shift clustering [Siew 2018, sec. III; Comaniciu 2002]: every point climbs to a local
/// maximum of the density of points (Epanechnikov kernel of radius `bandwidth`, m: each step goes
/// to the mean of all points within the radius). Points whose maxima are nearer than half the
/// bandwidth are one cluster. Points are found through a grid, so that the time grows with the
/// number of points times the number of points within the bandwidth. The order of clusters is that
/// of their first points.
template <int D>
std::vector<PointCluster<D>> meanShift(const std::vector<Eigen::Matrix<double, D, 1>>& points,
                                       double bandwidth);

/// Where the mean shift from `start` ends, using all points within the bandwidth in every step.
template <int D>
Eigen::Matrix<double, D, 1> climb(const std::vector<Eigen::Matrix<double, D, 1>>& points,
                                  double bandwidth, Eigen::Matrix<double, D, 1> start);

/// Joins clusters that a chain of points connects whose gaps are at most `gap` (m): a surface that
/// is longer than the bandwidth, as the side of a vehicle, is one object. The mode becomes the
/// mean.
template <int D>
std::vector<PointCluster<D>> joinConnected(const std::vector<Eigen::Matrix<double, D, 1>>& points,
                                           std::vector<PointCluster<D>> clusters, double gap);

}  // namespace kestrel
