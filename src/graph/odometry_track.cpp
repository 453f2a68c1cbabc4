// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/odometry_track.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

/// Medians of the squares of one and of two normal variables with variance 1.
constexpr double kMedianOfOne = 0.455, kMedianOfTwo = 1.386;
/// Smallest errors: of a pose, and their growth over a meter.
constexpr double kLeastM = 0.01, kLeastRad = 0.003;
constexpr double kLeastGrowthM = 0.01, kLeastGrowthRad = 0.001;
/// A turn of one rad is worth as much as this distance.
constexpr double kTurnM = 0.5;
/// Gains are learned over segments of this length.
constexpr double kSegmentM = 10.0;
/// Fewer comparisons say nothing.
constexpr std::size_t kFewest = 5;
/// Odometry and matches agree below this chi2: 99 % of three degrees of freedom.
constexpr double kMostChi2 = 11.345;
/// So many poses in a row may be wrong.
constexpr std::size_t kMostWrong = 6;
/// Factor of the information of a match that may be wrong and contradicts the odometry.
constexpr double kWeak = 1e-4;
constexpr double kLeastLengthM = 0.01;

double square(double x) { return x * x; }

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double lengthOf(const Pose2& motion) { return motion.distance() + kTurnM * std::abs(motion.yaw); }

}  // namespace

void OdometryTrack::add(double time, const std::optional<Pose2>& odom_T_base) {
  if (!odom_T_base) return recent_.clear();
  const Sample sample{time, *odom_T_base};
  for (std::size_t i = 0; i < kAround && i < keyframes_.size(); ++i) {
    TrackedKeyframe& keyframe = keyframes_[keyframes_.size() - 1 - i];
    if (keyframe.samples.size() <= keyframe.own + kAround) keyframe.samples.push_back(sample);
  }
  if (recent_.size() > kAround) recent_.erase(recent_.begin());
  recent_.push_back(sample);
}

void OdometryTrack::addKeyframe(std::size_t keyframe, const Pose2& local_T_base) {
  if (recent_.empty()) return;
  keyframes_.push_back({keyframe, local_T_base, recent_, recent_.size() - 1});
}

std::vector<OdometryTrack::Point> OdometryTrack::pointsAt(double delay_steps,
                                                          const OdometryChain& chain) const {
  std::vector<Point> result;
  const double floor = std::floor(delay_steps), share = delay_steps - floor;
  for (const TrackedKeyframe& keyframe : keyframes_) {
    const double first = static_cast<double>(keyframe.own) + floor;
    const double last = share > 0.0 ? first + 1.0 : first;
    if (first < 0.0 || last >= static_cast<double>(keyframe.samples.size())) continue;
    const Pose2& a = keyframe.samples[static_cast<std::size_t>(first)].odom_T_base;
    const Pose2& b = keyframe.samples[static_cast<std::size_t>(last)].odom_T_base;
    Point point{keyframe.number, keyframe.local_T_base, interpolate(a, b, share), 0.0};
    if (!result.empty()) {
      const bool same = chain.partOf(result.back().keyframe) == chain.partOf(keyframe.number);
      point.path_m = result.back().path_m +
                     (same ? lengthOf(result.back().matched.between(point.matched)) : 0.0);
    }
    result.push_back(point);
  }
  return result;
}

namespace {

/// The difference between matches and odometry over one interval.
struct Difference {
  Eigen::Vector2d position;
  double yaw;
};

template <typename Point>
Difference differenceOf(const std::vector<Point>& points, std::size_t i, std::size_t j) {
  const auto turnAt = [&](std::size_t k) {
    return normalizeAngle(points[k].matched.yaw - points[k].measured.yaw);
  };
  const double reference = turnAt((i + j) / 2);
  double mean = 0.0;
  for (std::size_t k = i; k <= j; ++k) mean += normalizeAngle(turnAt(k) - reference);
  mean = reference + mean / static_cast<double>(j - i + 1);
  const Eigen::Vector2d matched = points[j].matched.translation() - points[i].matched.translation();
  const Eigen::Vector2d measured =
      points[j].measured.translation() - points[i].measured.translation();
  return {matched - Pose2(0.0, 0.0, mean).rotation() * measured,
          normalizeAngle(turnAt(j) - turnAt(i))};
}

}  // namespace

void OdometryTrack::learnDelay(const OdometryChain& chain) {
  double least = 0.0;
  for (const double steps : {0.0, 0.5, -0.5, 1.0, -1.0, 1.5, -1.5, 2.0, -2.0}) {
    const std::vector<Point> points = pointsAt(steps, chain);
    std::vector<double> positions, yaws;
    for (std::size_t i = 1; i < points.size(); ++i) {
      if (chain.partOf(points[i - 1].keyframe) != chain.partOf(points[i].keyframe)) continue;
      const Difference difference = differenceOf(points, i - 1, i);
      positions.push_back(difference.position.squaredNorm());
      yaws.push_back(square(difference.yaw));
    }
    if (positions.size() < kFewest) continue;
    const double cost = (square(kLeastM) + median(positions)) * (square(kLeastRad) + median(yaws));
    if (least > 0.0 && cost >= least) continue;
    least = cost;
    delay_steps_ = steps;
  }
}

void OdometryTrack::correct(std::vector<Point>& points) const {
  if (points.empty()) return;
  Pose2 before = points.front().measured, result = before;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Pose2 motion = before.between(points[i].measured);
    before = points[i].measured;
    result = result * Pose2(worth_.scale * motion.x, worth_.scale * motion.y,
                            motion.yaw + worth_.yaw_per_m * motion.distance() +
                                worth_.yaw_per_rad * motion.yaw);
    points[i].measured = result;
  }
}

/// Systematic errors, where they are larger than those of the matches can be.
void OdometryTrack::learnGains(const OdometryChain& chain) {
  constexpr double kSignificant = 16.0;  // four sigmas
  worth_.scale = 1.0;
  worth_.yaw_per_m = worth_.yaw_per_rad = 0.0;
  corrected_ = false;
  std::vector<Point> points = pointsAt(delay_steps_, chain);
  struct Segment {
    double distance, turn, yaw;
    std::size_t i, j;
  };
  std::vector<Segment> segments;
  for (std::size_t i = 0, j = 0; i < points.size(); i = std::max(j, i + 1)) {
    double distance = 0.0;
    for (j = i + 1; j < points.size() && distance < kSegmentM; ++j)
      distance += points[j - 1].measured.between(points[j].measured).distance();
    --j;
    if (j <= i || distance < kSegmentM) break;
    if (chain.partOf(points[i].keyframe) != chain.partOf(points[j].keyframe)) continue;
    double turn = 0.0;
    for (std::size_t k = i + 1; k <= j; ++k)
      turn += normalizeAngle(points[k].measured.yaw - points[k - 1].measured.yaw);
    segments.push_back({distance, turn, differenceOf(points, i, j).yaw, i, j});
  }
  if (segments.size() < kFewest) return;
  std::vector<double> squares;
  for (const Segment& s : segments) squares.push_back(square(s.yaw));
  double variance = std::max(median(squares) / kMedianOfOne, square(kLeastRad));
  Eigen::Vector2d gains = Eigen::Vector2d::Zero();
  Eigen::Matrix2d normals;
  for (int round = 0; round < 5; ++round) {
    normals.setZero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    squares.clear();
    for (const Segment& s : segments) {
      const Eigen::Vector2d cause(s.distance, s.turn);
      const double error = s.yaw - gains.dot(cause);
      const double weight = 1.0 / (variance + square(error));
      squares.push_back(square(error));
      normals += weight * cause * cause.transpose();
      right += weight * s.yaw * cause;
    }
    normals += Eigen::Matrix2d(Eigen::Vector2d(square(1.0 / 0.02), square(1.0 / 0.1)).asDiagonal());
    gains = normals.inverse() * right;
    variance = std::max(median(squares) / kMedianOfOne, square(kLeastRad));
  }
  const bool turns = gains.dot(normals * gains) > kSignificant;
  if (turns) worth_.yaw_per_m = gains.x(), worth_.yaw_per_rad = gains.y();
  correct(points);
  double squares_d = 0.0, products = 0.0;
  double scale = 1.0;
  variance = square(0.1 * kSegmentM);
  for (int round = 0; round < 5; ++round) {
    squares_d = products = 0.0;
    squares.clear();
    for (const Segment& s : segments) {
      const double measured =
          (points[s.j].measured.translation() - points[s.i].measured.translation()).norm();
      const double matched =
          (points[s.j].matched.translation() - points[s.i].matched.translation()).norm();
      const double error = matched - scale * measured;
      const double weight = 1.0 / (variance + square(error));
      squares.push_back(square(error));
      squares_d += weight * square(measured);
      products += weight * measured * (matched - measured);
    }
    scale = 1.0 + products / (squares_d + square(1.0 / 0.1));
    variance = std::max(median(squares) / kMedianOfOne, square(kLeastM));
  }
  const bool scaled = square(scale - 1.0) * squares_d > kSignificant;
  if (scaled) worth_.scale = scale;
  corrected_ = turns || scaled;
}

void OdometryTrack::learnErrors(const OdometryChain& chain) {
  std::vector<Point> points = pointsAt(delay_steps_, chain);
  correct(points);
  // Least squares of variance = 2 jitter + growth * distance, relative to the variance.
  Eigen::Matrix2d normals[2] = {Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero()};
  Eigen::Vector2d right[2] = {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  double least_growth[2] = {square(kLeastGrowthM), square(kLeastGrowthRad)};
  for (std::size_t n = 1; n < points.size() / 2; n *= 2) {
    std::vector<double> positions, yaws, claimed_positions, claimed_yaws, lengths;
    for (std::size_t i = 0; i + n < points.size(); i += std::max<std::size_t>(1, n / 8)) {
      const std::size_t a = points[i].keyframe, b = points[i + n].keyframe;
      if (chain.partOf(a) != chain.partOf(b)) continue;
      const Difference difference = differenceOf(points, i, i + n);
      positions.push_back(difference.position.squaredNorm() / kMedianOfTwo);
      yaws.push_back(square(difference.yaw) / kMedianOfOne);
      lengths.push_back(points[i + n].path_m - points[i].path_m);
      const Eigen::Matrix3d noise = chain.noiseBetween(a, b);
      const Pose2& middle = chain.pose((a + b) / 2);
      Eigen::Matrix3d to = Eigen::Matrix3d::Identity();
      to.topRightCorner<2, 1>() = Eigen::Vector2d(-middle.y, middle.x);
      const Eigen::Matrix3d there = to * noise * to.transpose();
      claimed_positions.push_back(0.5 * (there(0, 0) + there(1, 1)));
      claimed_yaws.push_back(noise(2, 2));
    }
    if (positions.size() < kFewest) break;
    const double length = median(lengths);
    const double found[2] = {median(positions), median(yaws)};
    const double claimed[2] = {median(claimed_positions), median(claimed_yaws)};
    if (std::getenv("OD_DEBUG"))
      std::fprintf(stderr,
                   "  n %zu length %.1f position %.3f claimed %.3f yaw %.3f claimed %.3f deg\n", n,
                   length, std::sqrt(found[0]), std::sqrt(claimed[0]), 57.3 * std::sqrt(found[1]),
                   57.3 * std::sqrt(claimed[1]));
    for (int c = 0; c < 2; ++c) {
      const double value = std::max(0.0, found[c] - claimed[c]);
      const double weight = 1.0 / square(found[c] + 1e-9);
      const Eigen::Vector2d cause(2.0, length);
      normals[c] += weight * cause * cause.transpose();
      right[c] += weight * value * cause;
      if (corrected_) least_growth[c] = std::max(least_growth[c], claimed[c] / length * 0.25);
    }
  }
  double jitter[2] = {square(0.1), square(0.1)}, growth[2] = {square(0.3), square(0.1)};
  for (int c = 0; c < 2; ++c) {
    if (normals[c](1, 1) <= 0.0) continue;
    Eigen::Vector2d x = normals[c].determinant() > 1e-12 * square(normals[c].trace())
                            ? Eigen::Vector2d(normals[c].inverse() * right[c])
                            : Eigen::Vector2d(0.0, right[c].y() / normals[c](1, 1));
    if (x.x() < 0.0) x = {0.0, right[c].y() / normals[c](1, 1)};
    if (x.y() < 0.0) x = {right[c].x() / normals[c](0, 0), 0.0};
    jitter[c] = x.x(), growth[c] = x.y();
  }
  worth_.position_m2 = square(kLeastM) + jitter[0];
  worth_.yaw_rad2 = square(kLeastRad) + jitter[1];
  worth_.position_growth_m = std::max(least_growth[0], growth[0]);
  worth_.yaw_growth_rad2_m = std::max(least_growth[1], growth[1]);
}

void OdometryTrack::learn(const OdometryChain& chain) {
  learnDelay(chain);
  learnGains(chain);
  learnErrors(chain);
  if (std::getenv("OD_DEBUG"))
    std::fprintf(stderr,
                 "n %zu delay %.2f scale %.4f yaw/m %.5f yaw/rad %.4f jitter %.3f m %.2f deg "
                 "growth %.4f m %.3f deg\n",
                 keyframes_.size(), delay_steps_, worth_.scale, worth_.yaw_per_m,
                 worth_.yaw_per_rad, std::sqrt(worth_.position_m2),
                 57.3 * std::sqrt(worth_.yaw_rad2), std::sqrt(worth_.position_growth_m),
                 57.3 * std::sqrt(worth_.yaw_growth_rad2_m));
}

/// Variances of the error of the odometry from `a` to `b`, with that of both poses.
Eigen::Vector3d OdometryTrack::varianceBetween(const Point& a, const Point& b) const {
  const Pose2 motion = a.measured.between(b.measured);
  const double length = lengthOf(motion);
  const double yaw = 2.0 * worth_.yaw_rad2 + worth_.yaw_growth_rad2_m * length;
  const double position = 2.0 * worth_.position_m2 + worth_.position_growth_m * length +
                          yaw * motion.translation().squaredNorm();
  return {position, position, yaw};
}

/// Whether the odometry from `a` to `b` agrees with the matches; `yaw`: at least in yaw.
bool OdometryTrack::agree(const Point& a, const Point& b, const OdometryChain& chain,
                          bool yaw) const {
  const Pose2 error = a.measured.between(b.measured).between(a.matched.between(b.matched));
  const Eigen::Matrix3d to_b = chain.pose(b.keyframe).inverse().adjoint();
  const Eigen::Matrix3d expected =
      Eigen::Matrix3d(varianceBetween(a, b).asDiagonal()) +
      to_b * chain.noiseBetween(a.keyframe, b.keyframe) * to_b.transpose();
  if (yaw) return square(error.yaw) <= kMostChi2 * expected(2, 2);
  const Eigen::Vector3d e(error.x, error.y, error.yaw);
  return e.dot(expected.inverse() * e) <= kMostChi2;
}

/// The first point from `i` on that agrees with `last`; `i` if none of the next ones does.
std::size_t OdometryTrack::nextUsable(const std::vector<Point>& points, const Point& last,
                                      std::size_t i, const OdometryChain& chain) const {
  const std::size_t end = std::min(points.size(), i + kMostWrong);
  for (const bool yaw : {false, true}) {
    for (std::size_t next = i; next < end; ++next) {
      if (chain.partOf(last.keyframe) != chain.partOf(points[next].keyframe)) break;
      if (agree(last, points[next], chain, yaw)) return next;
    }
  }
  return i;
}

/// Without poses that contradict the poses before and after them, which agree with each other: they
/// were measured at another time.
std::vector<OdometryTrack::Point> OdometryTrack::usable(const OdometryChain& chain) const {
  if (worth_.position_m2 <= 0.0) return {};  // nothing was learned yet
  std::vector<Point> points = pointsAt(delay_steps_, chain);
  correct(points);
  std::vector<Point> result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!result.empty()) i = nextUsable(points, result.back(), i, chain);
    result.push_back(points[i]);
  }
  return result;
}

void OdometryTrack::weaken(PoseGraph& graph, const OdometryChain& chain,
                           const std::vector<bool>& doubtful) const {
  const std::vector<Point> points = usable(chain);
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Point &a = points[i - 1], &b = points[i];
    if (chain.partOf(a.keyframe) != chain.partOf(b.keyframe) || agree(a, b, chain, false)) continue;
    for (PoseEdge& edge : graph.edges)
      if (edge.kind == EdgeKind::kOdometry && edge.from >= a.keyframe && edge.to <= b.keyframe &&
          doubtful[edge.to])
        edge.information *= kWeak;
  }
}

void OdometryTrack::addTo(PoseGraph& graph, const OdometryChain& chain) const {
  const std::vector<Point> points = usable(chain);
  const Eigen::Vector3d jitter(worth_.position_m2, worth_.position_m2, worth_.yaw_rad2);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t vertex = graph.vertices.size();
    graph.vertices.push_back({graph.vertices[points[i].keyframe].pose, false});
    graph.edges.push_back({vertex, points[i].keyframe, Pose2(),
                           Eigen::Matrix3d(jitter.cwiseInverse().asDiagonal()), EdgeKind::kLoop});
    if (i == 0 || chain.partOf(points[i - 1].keyframe) != chain.partOf(points[i].keyframe))
      continue;
    const Pose2 motion = points[i - 1].measured.between(points[i].measured);
    const double length = std::max(kLeastLengthM, lengthOf(motion));
    const double yaw = worth_.yaw_growth_rad2_m * length;
    const double position =
        worth_.position_growth_m * length + yaw * motion.translation().squaredNorm() / 3.0;
    const Eigen::Vector3d growth(position, position, yaw);
    graph.edges.push_back({vertex - 1, vertex, motion,
                           Eigen::Matrix3d(growth.cwiseInverse().asDiagonal()), EdgeKind::kLoop});
  }
}

}  // namespace kestrel
