// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/lidar/cloud_icp.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "kestrel_slam/geometry/wilson_bound.h"

namespace kestrel {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr std::size_t kFewestPairs = 6;
constexpr double kStill_m = 1e-4, kStill_rad = 2e-6;  ///< a smaller step ends the iteration
/// A few pairs may change for ever. Steps up to this are far below what the maps resolve.
constexpr double kSettled_m = 0.005, kSettled_rad = 3e-4;
constexpr double kExplained = 3.0;  ///< standard deviations of the distance of a pair
/// The scale of the kernel: from this, narrower with each iteration, to a multiple of the noise.
constexpr double kWidestKernel_m = 0.5, kNarrowing = 0.7, kNarrowestKernel = 2.0;
constexpr double kSearchStep_m = 0.5;
constexpr std::size_t kSearchPoints = 1000, kSearchTrials = 5;

/// What can be paired by the metric.
std::vector<SurfaceCell> usableCells(const std::vector<SurfaceCell>& cells, IcpMetric metric) {
  std::vector<SurfaceCell> usable;
  for (const SurfaceCell& cell : cells) {
    const bool is_plane = cell.normal != Eigen::Vector3f::Zero();
    if (is_plane || metric == IcpMetric::kPoint) usable.push_back(cell);
  }
  return usable;
}

std::vector<Eigen::Vector3f> meansOf(const std::vector<SurfaceCell>& cells) {
  std::vector<Eigen::Vector3f> means;
  means.reserve(cells.size());
  for (const SurfaceCell& cell : cells) means.push_back(cell.mean);
  return means;
}

/// Adds a pair with `direction` (unit) as the direction in which its distance is measured.
void addPair(const Eigen::Vector3d& arm, const Eigen::Vector3d& direction, double distance,
             double weight, Matrix6& information, Vector6& gradient) {
  Vector6 jacobian;
  jacobian << direction, arm.cross(direction);
  information.selfadjointView<Eigen::Lower>().rankUpdate(jacobian, weight);
  gradient += jacobian * (weight * distance);
}

/// The pairs by the main direction that is nearest to their normal: floors, walls, and what stands
/// across the street, however the lidar is turned.
template <typename Pairs>
std::array<Pairs, 3> byDirection(const Pairs& pairs) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& pair : pairs) spread += pair.normal * pair.normal.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(spread);
  std::array<Pairs, 3> parts;
  for (const auto& pair : pairs) {
    Eigen::Index direction = 0;
    (solver.eigenvectors().transpose() * pair.normal).cwiseAbs().maxCoeff(&direction);
    parts[static_cast<std::size_t>(direction)].push_back(pair);
  }
  return parts;
}

template <typename Pairs>
void rejectWorst(Pairs& pairs, double share) {
  const auto kept =
      static_cast<std::size_t>(std::lround((1.0 - share) * static_cast<double>(pairs.size())));
  if (kept >= pairs.size()) return;
  std::nth_element(
      pairs.begin(), pairs.begin() + static_cast<std::ptrdiff_t>(kept), pairs.end(),
      [](const auto& a, const auto& b) { return std::abs(a.distance) < std::abs(b.distance); });
  pairs.resize(kept);
}

template <typename Pairs>
double rmsOf(const Pairs& pairs) {
  double sum = 0.0;
  for (const auto& pair : pairs) sum += pair.distance * pair.distance;
  return std::sqrt(sum / static_cast<double>(pairs.size()));
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

struct CloudIcp::Pair {
  Eigen::Vector3d point;  ///< in the map
  Eigen::Vector3d mean, normal, tilt;
  double thickness;  ///< of the plane
  double distance, weight = 1.0;

  double fromPlane() const { return std::abs(normal.dot(point - mean)); }
  /// Of the distance, because the plane may be thick or turned.
  double variance() const {
    const double cosine = std::sqrt(std::max(0.0, 1.0 - tilt.squaredNorm()));
    const double along = tilt.dot(point - mean), across = (1.0 - cosine) * fromPlane();
    return thickness * thickness + along * along + across * across;
  }
};

CloudIcp::CloudIcp(const std::vector<SurfaceCell>& cells, const CloudIcpConfig& config)
    : config_(config), cells_(usableCells(cells, config.metric)), means_(meansOf(cells_)) {}

CloudIcpResult CloudIcp::align(const std::vector<Eigen::Vector3d>& all_points,
                               const Eigen::Isometry3d& guess) const {
  const std::vector<Eigen::Vector3d> points = balanced(all_points, guess);
  CloudIcpResult result;
  result.pose = guess;
  if (cells_.empty()) return result;
  refine(points, result);
  judge(pairsOf(points, result.pose), result);
  return result;
}

/// At most `max_points`, of each direction as many: most of all points lie on the ground.
std::vector<Eigen::Vector3d> CloudIcp::balanced(const std::vector<Eigen::Vector3d>& points,
                                                const Eigen::Isometry3d& guess) const {
  const std::size_t count = config_.max_points;
  if (points.size() <= count) return points;
  std::array<Pairs, 3> parts = byDirection(pairsOf(points, guess));
  std::sort(parts.begin(), parts.end(),
            [](const Pairs& a, const Pairs& b) { return a.size() < b.size(); });
  const Eigen::Isometry3d back = guess.inverse();
  std::vector<Eigen::Vector3d> chosen;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::size_t share =
        std::min(parts[i].size(), (count - chosen.size()) / (parts.size() - i));
    for (std::size_t k = 0; k < share; ++k) {
      chosen.push_back(back * parts[i][k * parts[i].size() / share].point);
    }
  }
  return chosen;
}

void CloudIcp::refine(const std::vector<Eigen::Vector3d>& points, CloudIcpResult& result) const {
  Vector6 from_guess = Vector6::Zero();
  for (int i = 0; i < config_.max_iterations && !result.converged; ++i) {
    ++result.iterations;
    Pairs pairs = pairsOf(points, result.pose);
    rejectWorst(pairs, config_.rejected_share);
    result.pairs = pairs.size();
    if (pairs.size() < kFewestPairs) return;
    result.rms = rmsOf(pairs);
    weigh(pairs, kernelOf(i));
    const Vector6 change = step(pairs, from_guess, result.pose.translation());
    from_guess += change;
    result.pose = moved(result.pose, change);
    const bool is_last = i + 1 == config_.max_iterations;
    result.converged = change.head<3>().norm() < (is_last ? kSettled_m : kStill_m) &&
                       change.tail<3>().norm() < (is_last ? kSettled_rad : kStill_rad);
  }
}

CloudIcpResult CloudIcp::search(const std::vector<Eigen::Vector3d>& points,
                                const Eigen::Isometry3d& guess, double radius) const {
  struct Candidate {
    double closeness;
    Eigen::Isometry3d pose;
  };
  const std::vector<Eigen::Vector3d> few = thinned(points, kSearchPoints);
  const int steps = static_cast<int>(std::ceil(radius / kSearchStep_m));
  std::vector<Candidate> candidates;
  for (int x = -steps; x <= steps; ++x) {
    for (int y = -steps; y <= steps; ++y) {
      Candidate candidate{0.0, guess};
      candidate.pose.translation() += kSearchStep_m * Eigen::Vector3d(x, y, 0.0);
      candidate.closeness = closenessOf(pairsOf(few, candidate.pose));
      candidates.push_back(candidate);
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.closeness > b.closeness; });
  candidates.resize(std::min(candidates.size(), kSearchTrials));
  CloudIcpResult best = align(points, guess);
  for (const Candidate& candidate : candidates) {
    const CloudIcpResult found = align(points, candidate.pose);
    if (found.converged && found.is_fixed && found.agreement > best.agreement) best = found;
  }
  return best;
}

/// Directions with too few pairs say nothing.
void CloudIcp::judge(const Pairs& pairs, CloudIcpResult& result) const {
  result.agreement = result.possible_agreement = 1.0;
  result.is_fixed = true;
  for (const Pairs& part : byDirection(pairs)) {
    if (part.size() < kFewestPairs) {
      result.is_fixed = false;
      continue;
    }
    result.has_pairs = true;
    const auto explained = std::count_if(part.begin(), part.end(), [this](const Pair& pair) {
      return pair.fromPlane() < kExplained * config_.pair_sigma_m;
    });
    const auto count = static_cast<double>(part.size());
    const double share = static_cast<double>(explained) / count;
    result.agreement = std::min(result.agreement, share);
    result.possible_agreement = std::min(result.possible_agreement, wilsonUpperBound(share, count));
  }
}

/// How near the surfaces are, 0 to 3: a mean for each direction. A sum over all points would be
/// largest where the rings of two sweeps lie on each other, that is without motion.
double CloudIcp::closenessOf(const Pairs& pairs) const {
  double sum = 0.0;
  for (const Pairs& part : byDirection(pairs)) {
    if (part.size() < kFewestPairs) continue;
    double of_part = 0.0;
    for (const Pair& pair : part) {
      const double distance = pair.fromPlane() / kSearchStep_m;
      of_part += std::max(0.0, 1.0 - distance * distance);
    }
    sum += of_part / static_cast<double>(part.size());
  }
  return sum;
}

CloudIcp::Pairs CloudIcp::pairsOf(const std::vector<Eigen::Vector3d>& points,
                                  const Eigen::Isometry3d& pose) const {
  Pairs pairs;
  pairs.reserve(points.size());
  const auto reach = static_cast<float>(config_.reach_m);
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d in_map = pose * point;
    const auto nearest = means_.nearest(in_map.cast<float>(), reach);
    if (!nearest) continue;
    const SurfaceCell& cell = cells_[*nearest];
    Pair pair{in_map,
              cell.mean.cast<double>(),
              cell.normal.cast<double>(),
              cell.tilt.cast<double>(),
              cell.thickness,
              0.0};
    pair.distance = config_.metric == IcpMetric::kPlane ? pair.normal.dot(in_map - pair.mean)
                                                        : (in_map - pair.mean).norm();
    pairs.push_back(pair);
  }
  return pairs;
}

/// The kernel of Geman and McClure: what does not fit loses its weight. Thick planes, as those of
/// leaves, and planes that may be turned say less.
void CloudIcp::weigh(Pairs& pairs, double scale) const {
  const double sigma2 = config_.pair_sigma_m * config_.pair_sigma_m;
  for (Pair& pair : pairs) {
    const double misfit = pair.distance / scale;
    const double fit = 1.0 / (1.0 + misfit * misfit);
    pair.weight = fit * fit * sigma2 / (sigma2 + pair.variance());
  }
}

/// Wide at first, so that a wrong guess does not make outliers of what is right.
double CloudIcp::kernelOf(int iteration) const {
  return std::max(kNarrowestKernel * config_.pair_sigma_m,
                  kWidestKernel_m * std::pow(kNarrowing, iteration));
}

/// The Gauss-Newton step of the pose: translation, and rotation about the lidar at `center`.
CloudIcp::Vector6 CloudIcp::step(const Pairs& pairs, const Vector6& from_guess,
                                 const Eigen::Vector3d& center) const {
  Matrix6 information = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
  for (const Pair& pair : pairs) {
    const Eigen::Vector3d arm = pair.point - center;
    if (config_.metric == IcpMetric::kPlane) {
      addPair(arm, pair.normal, pair.distance, pair.weight, information, gradient);
      continue;
    }
    const Eigen::Vector3d apart = pair.point - pair.mean;
    for (int i = 0; i < 3; ++i) {
      addPair(arm, Eigen::Vector3d::Unit(i), apart(i), pair.weight, information, gradient);
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
