// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/odometry_worth.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/square.h"

namespace kestrel {
namespace {

/// Medians of the squares of one normal variable of variance 1, and of the sum of two.
constexpr double kMedianOfOne = 0.455, kMedianOfTwo = 1.386;
/// Smallest errors of a pose, and of their growth over a meter.
constexpr double kLeastM = 0.01, kLeastYawRad = 0.003;
constexpr double kLeastGrowthM = 0.01, kLeastGrowthRad = 0.001;
/// Of the variance of the matches, what a corrected odometry has at least: it was compared with
/// them.
constexpr double kMatchShare = 0.25;
/// A turn of one rad counts as this distance.
constexpr double kTurnM = 0.5;
/// Systematic errors are looked for over segments of this length, and these are expected.
constexpr double kSegmentM = 10.0;
constexpr double kUsualYawPerM = 0.02, kUsualGain = 0.1;
/// A systematic error counts above this chi2: four standard deviations.
constexpr double kSignificant = 16.0;
/// Fewer comparisons say nothing.
constexpr std::size_t kFewest = 5;
constexpr int kRounds = 5;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// What the matches say more than the odometry, between two points.
struct Difference {
  Eigen::Vector2d position;
  double yaw;
};

/// Positions are compared in the mean direction of all points between, because a single yaw has an
/// error that would turn the whole distance.
Difference differenceBetween(const std::vector<OdometryPoint>& points, std::size_t i,
                             std::size_t j) {
  const auto turn_at = [&](std::size_t k) {
    return normalizeAngle(points[k].matched.yaw - points[k].measured.yaw);
  };
  const double middle = turn_at((i + j) / 2);
  double mean = 0.0;
  for (std::size_t k = i; k <= j; ++k) mean += normalizeAngle(turn_at(k) - middle);
  mean = middle + mean / static_cast<double>(j - i + 1);
  const Eigen::Vector2d matched = points[j].matched.translation() - points[i].matched.translation();
  const Eigen::Vector2d measured =
      points[j].measured.translation() - points[i].measured.translation();
  return {matched - Pose2(0.0, 0.0, mean).rotation() * measured,
          normalizeAngle(turn_at(j) - turn_at(i))};
}

bool areJoined(const std::vector<OdometryPoint>& points, std::size_t i, std::size_t j,
               const OdometryChain& chain) {
  return chain.partOf(points[i].keyframe) == chain.partOf(points[j].keyframe);
}

/// Effects as a linear function of two causes.
struct Fit {
  std::vector<Eigen::Vector2d> causes;
  std::vector<double> effects;
  Eigen::Vector2d gains = Eigen::Vector2d::Zero();
  double chi2 = 0.0;  ///< of the gains against zero

  /// Weighted least squares with Cauchy weights, because wheels slip. `usual`: expected size of the
  /// gains.
  void solve(const Eigen::Vector2d& usual, double least_error) {
    for (int round = 0; round < kRounds; ++round) {
      std::vector<double> squares;
      for (std::size_t i = 0; i < effects.size(); ++i)
        squares.push_back(square(effects[i] - gains.dot(causes[i])));
      const double variance = std::max(median(squares) / kMedianOfOne, square(least_error));
      Eigen::Matrix2d normals = usual.cwiseAbs2().cwiseInverse().asDiagonal();
      Eigen::Vector2d right = Eigen::Vector2d::Zero();
      for (std::size_t i = 0; i < effects.size(); ++i) {
        normals += causes[i] * causes[i].transpose() / (variance + squares[i]);
        right += causes[i] * effects[i] / (variance + squares[i]);
      }
      gains = normals.inverse() * right;
      chi2 = gains.dot(normals * gains);
    }
  }
};

/// A part of the way.
struct Segment {
  std::size_t first = 0, last = 0;
  double distance_m = 0.0, turn_rad = 0.0;
};

std::vector<Segment> segmentsOf(const std::vector<OdometryPoint>& points,
                                const OdometryChain& chain) {
  std::vector<Segment> result;
  Segment segment;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (!areJoined(points, i - 1, i, chain)) {
      segment = Segment{i, i, 0.0, 0.0};
      continue;
    }
    const Pose2 motion = points[i - 1].measured.between(points[i].measured);
    segment.distance_m += motion.distance();
    segment.turn_rad += motion.yaw;
    segment.last = i;
    if (segment.distance_m < kSegmentM) continue;
    result.push_back(segment);
    segment = Segment{i, i, 0.0, 0.0};
  }
  return result;
}

/// Errors of the yaw, where they are too large to be errors of the matches.
void learnTurn(const std::vector<OdometryPoint>& points, const std::vector<Segment>& segments,
               OdometryWorth& worth) {
  Fit fit;
  for (const Segment& segment : segments) {
    fit.causes.emplace_back(segment.distance_m, segment.turn_rad);
    fit.effects.push_back(differenceBetween(points, segment.first, segment.last).yaw);
  }
  fit.solve({kUsualYawPerM, kUsualGain}, kLeastYawRad);
  if (fit.chi2 <= kSignificant) return;
  worth.yaw_per_m = fit.gains.x();
  worth.yaw_per_rad = fit.gains.y();
}

void learnScale(const std::vector<OdometryPoint>& points, const std::vector<Segment>& segments,
                OdometryWorth& worth) {
  Fit fit;
  for (const Segment& segment : segments) {
    const OdometryPoint &a = points[segment.first], &b = points[segment.last];
    const double measured = a.measured.between(b.measured).distance();
    fit.causes.emplace_back(measured, 0.0);
    fit.effects.push_back(a.matched.between(b.matched).distance() - measured);
  }
  fit.solve({kUsualGain, kUsualGain}, kLeastM);
  if (fit.chi2 > kSignificant) worth.scale += fit.gains.x();
}

/// Fits variance = 2 jitter + growth * length, relative to the variance.
class ErrorFit {
 public:
  /// `intervals`: that do not overlap; the variance of `found` is proportional to its square.
  void add(double length, double found, double explained, double intervals) {
    constexpr double kTiny = 1e-9;
    const double weight = intervals / square(found + kTiny);
    const Eigen::Vector2d cause(2.0, length);
    normals_ += weight * cause * cause.transpose();
    right_ += weight * std::max(0.0, found - explained) * cause;
    explained_growth_ = std::max(explained_growth_, explained / length);
  }

  bool isEmpty() const { return normals_(0, 0) <= 0.0; }
  double explainedGrowth() const { return explained_growth_; }

  /// Jitter and growth. Neither is negative.
  Eigen::Vector2d solve() const {
    const Eigen::Vector2d both = normals_.ldlt().solve(right_);
    if (both.allFinite() && both.minCoeff() >= 0.0) return both;
    if (both.x() < 0.0) return {0.0, right_.y() / normals_(1, 1)};
    return {right_.x() / normals_(0, 0), 0.0};
  }

 private:
  Eigen::Matrix2d normals_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right_ = Eigen::Vector2d::Zero();
  double explained_growth_ = 0.0;
};

/// Differences between points of the same distance.
struct Differences {
  std::vector<double> lengths, positions, yaws, matched_positions, matched_yaws;

  void add(const std::vector<OdometryPoint>& points, std::size_t i, std::size_t j,
           const OdometryChain& chain) {
    const Difference difference = differenceBetween(points, i, j);
    positions.push_back(difference.position.squaredNorm() / kMedianOfTwo);
    yaws.push_back(square(difference.yaw) / kMedianOfOne);
    const std::size_t a = points[i].keyframe, b = points[j].keyframe;
    const Pose2& middle = chain.pose((a + b) / 2);
    Eigen::Matrix3d to_middle = Eigen::Matrix3d::Identity();
    to_middle.topRightCorner<2, 1>() = Eigen::Vector2d(-middle.y, middle.x);
    const Eigen::Matrix3d noise = to_middle * chain.noiseBetween(a, b) * to_middle.transpose();
    matched_positions.push_back(0.5 * (noise(0, 0) + noise(1, 1)));
    matched_yaws.push_back(noise(2, 2));
  }
};

void learnErrors(const std::vector<OdometryPoint>& points, const OdometryChain& chain,
                 OdometryWorth& worth) {
  std::vector<double> path(points.size(), 0.0);
  for (std::size_t i = 1; i < points.size(); ++i)
    path[i] = path[i - 1] + lengthOf(points[i - 1].matched.between(points[i].matched));
  ErrorFit position, yaw;
  for (std::size_t n = 1; 2 * n < points.size(); n *= 2) {
    Differences all;
    for (std::size_t i = 0; i + n < points.size(); i += std::max<std::size_t>(1, n / 8)) {
      if (!areJoined(points, i, i + n, chain)) continue;
      all.add(points, i, i + n, chain);
      all.lengths.push_back(path[i + n] - path[i]);
    }
    if (all.lengths.size() < kFewest) break;
    const double length = std::max(kLeastM, median(all.lengths));
    const double intervals = static_cast<double>(points.size()) / static_cast<double>(n);
    position.add(length, median(all.positions), median(all.matched_positions), intervals);
    yaw.add(length, median(all.yaws), median(all.matched_yaws), intervals);
  }
  if (position.isEmpty()) return;
  const double share = worth.isCorrected() ? kMatchShare : 0.0;
  const Eigen::Vector2d of_position = position.solve(), of_yaw = yaw.solve();
  worth.position_m2 = square(kLeastM) + of_position.x();
  worth.yaw_rad2 = square(kLeastYawRad) + of_yaw.x();
  worth.position_growth =
      std::max({of_position.y(), square(kLeastGrowthM), share * position.explainedGrowth()});
  worth.yaw_growth = std::max({of_yaw.y(), square(kLeastGrowthRad), share * yaw.explainedGrowth()});
}

}  // namespace

double lengthOf(const Pose2& motion) { return motion.distance() + kTurnM * std::abs(motion.yaw); }

OdometryWorth worthOf(std::vector<OdometryPoint> points, const OdometryChain& chain) {
  OdometryWorth worth;
  const std::vector<Segment> segments = segmentsOf(points, chain);
  if (segments.size() >= kFewest) {
    OdometryWorth turn;
    learnTurn(points, segments, turn);
    correct(turn, points);
    worth = turn;
    learnScale(points, segments, worth);
    OdometryWorth scale;
    scale.scale = worth.scale;
    correct(scale, points);
  }
  learnErrors(points, chain, worth);
  return worth;
}

void correct(const OdometryWorth& worth, std::vector<OdometryPoint>& points) {
  if (points.empty()) return;
  Pose2 before = points.front().measured, result = before;
  for (OdometryPoint& point : points) {
    const Pose2 motion = before.between(point.measured);
    before = point.measured;
    const double turn = worth.yaw_per_m * motion.distance() + worth.yaw_per_rad * motion.yaw;
    result = result * Pose2(worth.scale * motion.x, worth.scale * motion.y, motion.yaw + turn);
    point.measured = result;
  }
}

Eigen::Vector3d varianceOf(const OdometryWorth& worth, const Pose2& motion) {
  const double length = lengthOf(motion);
  const double yaw = 2.0 * worth.yaw_rad2 + worth.yaw_growth * length;
  const double position = 2.0 * worth.position_m2 + worth.position_growth * length +
                          yaw * motion.translation().squaredNorm();
  return {position, position, yaw};
}

bool isExpected(const Pose2& error, const Eigen::Matrix3d& covariance) {
  constexpr double kMostChi2 = 11.345;  // 99 % of three degrees of freedom
  const Eigen::Vector3d e(error.x, error.y, error.yaw);
  return e.dot(covariance.inverse() * e) <= kMostChi2;
}

double stepDifference(const std::vector<OdometryPoint>& points, const OdometryChain& chain) {
  std::vector<double> positions, yaws;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (!areJoined(points, i - 1, i, chain)) continue;
    const Difference difference = differenceBetween(points, i - 1, i);
    positions.push_back(difference.position.squaredNorm());
    yaws.push_back(square(difference.yaw));
  }
  if (positions.size() < kFewest) return std::numeric_limits<double>::infinity();
  return (square(kLeastM) + median(positions)) * (square(kLeastYawRad) + median(yaws));
}

}  // namespace kestrel
