// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/consistency.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/geometry/symmetric_axes.h"

namespace kestrel {
namespace {

constexpr double kInterval = 1.0;  ///< s

void addAxisErrors(const EvaluatedPose& pose, Consistency& result) {
  const Eigen::Vector2d error = pose.estimate.pose.translation() - pose.truth.translation();
  const SymmetricAxes<2> axes =
      symmetricAxes(Eigen::Matrix2d(pose.estimate.covariance().topLeftCorner<2, 2>()));
  const Eigen::Vector2d in_axes = (axes.eigenvectors.transpose() * error).cwiseAbs();
  const double sigma = std::sqrt(std::max(axes.eigenvalues(1), 0.0));
  result.worst_short_m = std::max(result.worst_short_m, in_axes(0));
  result.worst_long_m = std::max(result.worst_long_m, in_axes(1));
  if (sigma > 0.0) {
    result.worst_long_sigmas = std::max(result.worst_long_sigmas, in_axes(1) / sigma);
  }
}

}  // namespace

double neesOf(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  return error.dot(covariance.ldlt().solve(error));
}

std::pair<double, double> meanNeesBand(std::size_t count, double freedom) {
  constexpr double kQuantile = 1.959964;  // 97.5 % quantile of the normal distribution
  const double n = freedom * static_cast<double>(std::max<std::size_t>(count, 1));
  const double c = 2.0 / (9.0 * n);
  const auto quantile = [&](double z) {
    return freedom * std::pow(1.0 - c + z * std::sqrt(c), 3.0);
  };
  return {quantile(-kQuantile), quantile(kQuantile)};
}

Consistency consistencyOf(const std::vector<EvaluatedPose>& poses) {
  Consistency result;
  if (poses.empty()) return result;
  const EvaluatedPose* last = &poses.front();
  for (const EvaluatedPose& pose : poses) {
    if (&pose != &poses.front()) addAxisErrors(pose, result);
    if (pose.stamp - last->stamp < kInterval) continue;
    result.absolute.push_back(
        neesOf(offsetBetween(pose.truth, pose.estimate.pose), pose.estimate.covariance()));
    const Eigen::Vector3d error = offsetBetween(last->truth.between(pose.truth),
                                                last->estimate.pose.between(pose.estimate.pose));
    result.relative.push_back(neesOf(error, relativeCovariance(last->estimate, pose.estimate)));
    last = &pose;
  }
  return result;
}

double meanOf(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double shareWithin(const std::vector<double>& values, const std::pair<double, double>& band) {
  if (values.empty()) return 0.0;
  const auto inside = [&](double v) { return v >= band.first && v <= band.second; };
  return static_cast<double>(std::count_if(values.begin(), values.end(), inside)) /
         static_cast<double>(values.size());
}

}  // namespace kestrel
