// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/lidar/cloud_icp.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

namespace kestrel {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kLeafSize = 10;
constexpr std::size_t kFewestPairs = 6;
constexpr double kStill_m = 1e-4, kStill_rad = 2e-6;  ///< a smaller step ends the iteration

/// The interface that nanoflann needs.
struct Cells {
  std::vector<SurfaceCell> cells;

  std::size_t kdtree_get_point_count() const { return cells.size(); }
  float kdtree_get_pt(std::size_t index, std::size_t dimension) const {
    return cells[index].mean[static_cast<Eigen::Index>(dimension)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

/// Keeps the nearest point within a radius.
struct NearestWithin {
  float distance2;
  std::size_t index = 0;
  bool found = false;

  bool addPoint(float other2, std::size_t other) {
    if (other2 >= distance2) return true;
    distance2 = other2;
    index = other;
    found = true;
    return true;
  }
  float worstDist() const { return distance2; }
  bool full() const { return found; }
  bool empty() const { return !found; }
  std::size_t size() const { return found ? 1 : 0; }
  void sort() const {}
};

using Metric = nanoflann::L2_Simple_Adaptor<float, Cells>;
using Index = nanoflann::KDTreeSingleIndexAdaptor<Metric, Cells, 3>;

/// Adds a pair with `direction` (unit) as the direction in which its distance is measured.
void addPair(const Eigen::Vector3d& arm, const Eigen::Vector3d& direction, double distance,
             Matrix6& information, Vector6& gradient) {
  Vector6 jacobian;
  jacobian << direction, arm.cross(direction);
  information.selfadjointView<Eigen::Lower>().rankUpdate(jacobian);
  gradient += jacobian * distance;
}

Eigen::Isometry3d moved(const Eigen::Isometry3d& pose, const Vector6& step) {
  const double angle = step.tail<3>().norm();
  Eigen::Isometry3d result = pose;
  if (angle > 0.0) {
    result.linear() = Eigen::AngleAxisd(angle, step.tail<3>() / angle) * pose.linear();
  }
  result.translation() += step.head<3>();
  result.linear() = Eigen::Quaterniond(result.linear()).normalized().toRotationMatrix();
  return result;
}

std::vector<Eigen::Vector3d> thinned(const std::vector<Eigen::Vector3d>& points,
                                     std::size_t count) {
  if (points.size() <= count) return points;
  std::vector<Eigen::Vector3d> kept;
  for (std::size_t i = 0; i < count; ++i) kept.push_back(points[i * points.size() / count]);
  return kept;
}

}  // namespace

struct CloudIcp::Tree {
  explicit Tree(Cells usable) : data(std::move(usable)), index(3, data, {kLeafSize}) {
#if NANOFLANN_VERSION < 0x140  // the constructor of 1.3 (Ubuntu 20.04) does not build the tree
    index.buildIndex();
#endif
  }
  Cells data;
  Index index;
};

CloudIcp::CloudIcp(const std::vector<SurfaceCell>& cells, const CloudIcpConfig& config)
    : config_(config) {
  Cells usable;
  for (const SurfaceCell& cell : cells) {
    const bool is_plane = cell.normal != Eigen::Vector3f::Zero();
    if (is_plane || config.metric == IcpMetric::kPoint) usable.cells.push_back(cell);
  }
  tree_ = std::make_unique<Tree>(std::move(usable));
}

CloudIcp::~CloudIcp() = default;

CloudIcpResult CloudIcp::align(const std::vector<Eigen::Vector3d>& all_points,
                               const Eigen::Isometry3d& guess) const {
  const std::vector<Eigen::Vector3d> points = thinned(all_points, config_.max_points);
  CloudIcpResult result;
  result.pose = guess;
  if (tree_->data.cells.empty()) return result;
  Vector6 from_guess = Vector6::Zero();
  while (result.iterations < config_.max_iterations && !result.converged) {
    ++result.iterations;
    std::vector<Pair> pairs = pairsOf(points, result.pose);
    rejectWorst(pairs);
    result.pairs = pairs.size();
    if (pairs.size() < kFewestPairs) return result;
    double sum = 0.0;
    for (const Pair& pair : pairs) sum += pair.distance * pair.distance;
    result.rms = std::sqrt(sum / static_cast<double>(pairs.size()));
    const Vector6 change = step(pairs, from_guess, result.pose.translation());
    from_guess += change;
    result.pose = moved(result.pose, change);
    result.converged = change.head<3>().norm() < kStill_m && change.tail<3>().norm() < kStill_rad;
  }
  return result;
}

std::vector<CloudIcp::Pair> CloudIcp::pairsOf(const std::vector<Eigen::Vector3d>& points,
                                              const Eigen::Isometry3d& pose) const {
  std::vector<Pair> pairs;
  pairs.reserve(points.size());
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d in_map = pose * point;
    const Eigen::Vector3f place = in_map.cast<float>();
    NearestWithin nearest{static_cast<float>(config_.reach_m * config_.reach_m)};
    tree_->index.radiusSearchCustomCallback(place.data(), nearest);
    if (!nearest.found) continue;
    const SurfaceCell& cell = tree_->data.cells[nearest.index];
    Pair pair{in_map, cell.mean.cast<double>(), cell.normal.cast<double>(), 0.0};
    pair.distance = config_.metric == IcpMetric::kPlane ? pair.normal.dot(in_map - pair.mean)
                                                        : (in_map - pair.mean).norm();
    pairs.push_back(pair);
  }
  return pairs;
}

void CloudIcp::rejectWorst(std::vector<Pair>& pairs) const {
  const auto kept = static_cast<std::size_t>(
      std::lround((1.0 - config_.rejected_share) * static_cast<double>(pairs.size())));
  if (kept >= pairs.size()) return;
  std::nth_element(
      pairs.begin(), pairs.begin() + static_cast<std::ptrdiff_t>(kept), pairs.end(),
      [](const Pair& a, const Pair& b) { return std::abs(a.distance) < std::abs(b.distance); });
  pairs.resize(kept);
}

/// The Gauss-Newton step of the pose: translation, and rotation about the lidar at `center`.
Vector6 CloudIcp::step(const std::vector<Pair>& pairs, const Vector6& from_guess,
                       const Eigen::Vector3d& center) const {
  Matrix6 information = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
  for (const Pair& pair : pairs) {
    const Eigen::Vector3d arm = pair.point - center;
    if (config_.metric == IcpMetric::kPlane) {
      addPair(arm, pair.normal, pair.distance, information, gradient);
      continue;
    }
    const Eigen::Vector3d apart = pair.point - pair.mean;
    for (int i = 0; i < 3; ++i) {
      addPair(arm, Eigen::Vector3d::Unit(i), apart(i), information, gradient);
    }
  }
  Vector6 prior;
  prior << Eigen::Vector3d::Constant(config_.guess_sigma_m),
      Eigen::Vector3d::Constant(config_.guess_sigma_rad);
  prior = (config_.pair_sigma_m / prior.array()).square();
  information.diagonal() += prior;
  gradient += prior.cwiseProduct(from_guess);
  return -information.selfadjointView<Eigen::Lower>().ldlt().solve(gradient);
}

}  // namespace kestrel
