// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/map_uncertainty.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "kestrel_slam/geometry/pose_covariance.h"
#include "kestrel_slam/geometry/symmetric_axes.h"
#include "kestrel_slam/matching/covariance.h"

namespace kestrel {
namespace {

/// Number of sampled beams: one of kOneOf, at least kMinSamples, at most kMaxSamples.
constexpr std::size_t kOneOf = 10, kMinSamples = 16, kMaxSamples = 128;

Eigen::Matrix2d normalsOf(const Surfel& wall) {
  const Eigen::Vector3d shape = constraintOf(wall).cast<double>();
  Eigen::Matrix2d result;
  result << shape.x(), shape.y(), shape.y(), shape.z();
  return result;
}

}  // namespace

void MapUncertainty::add(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  scans_.push_back({pose, covariance});
}

Eigen::Matrix3d MapUncertainty::at(const SurfelField& surface, const Points& points,
                                   const Pose2& pose) const {
  const std::size_t samples =
      std::min(std::clamp(points.size() / kOneOf, kMinSamples, kMaxSamples), points.size());
  std::array<const Surfel*, kMaxSamples> walls{};
  std::size_t count = 0;
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < samples; ++i) {
    const std::size_t beam = i * points.size() / samples;
    const Eigen::Vector2d point = pose * Eigen::Vector2d(points[beam].cast<double>());
    const Surfel* wall = surface.nearest(point.cast<float>());
    if (wall == nullptr || wall->birth >= scans_.size()) continue;
    walls[count++] = wall;
    normals += normalsOf(*wall);
  }
  if (count == 0) return Eigen::Matrix3d::Zero();
  const Eigen::Vector2d weakest = symmetricAxes(normals).eigenvectors.col(0);
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  double weights = 0.0, weighted = 0.0;  // for the mean variance along the weakest direction
  for (std::size_t i = 0; i < count; ++i) {
    const InsertedScan& birth = scans_[walls[i]->birth];
    const Eigen::Matrix3d covariance =
        transported(birth.covariance, pose.translation() - birth.pose.translation());
    mean += covariance / static_cast<double>(count);
    // Squared: many walls differ a little from the direction, because their own direction is noisy.
    const double along = static_cast<double>(kAlongWeight);
    const double share = std::max(weakest.dot(normalsOf(*walls[i]) * weakest) - along, 0.0);
    const double weight = share * share;
    weights += weight;
    weighted += weight * weakest.dot(covariance.topLeftCorner<2, 2>() * weakest);
  }
  const double variance = weakest.dot(mean.topLeftCorner<2, 2>() * weakest);
  if (weighted > weights * variance && variance > 0.0) {
    mean = stretched(mean, weakest, std::sqrt(weighted / weights / variance));
  }
  return mean;
}

}  // namespace kestrel
