// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/odometry_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kestrel {
namespace {

/// So many poses in a row may be wrong.
constexpr std::size_t kMostWrong = 6;

class Selection {
 public:
  Selection(const std::vector<OdometryPoint>& points, const OdometryWorth& worth,
            const OdometryChain& chain, const std::vector<bool>& doubtful, bool is_late)
      : points_(points), worth_(worth), chain_(chain), doubtful_(doubtful), is_late_(is_late) {}

  /// Selects twice: what is refuted depends on how often the first pass finds each kind.
  OdometrySelection run() {
    select();
    is_counting_ = false;
    return select();
  }

 private:
  OdometrySelection select() {
    OdometrySelection result;
    result.refuted.resize(doubtful_.size(), false);
    std::size_t last = 0;  // the next ones are compared with this one
    for (std::size_t i = 0; i < points_.size(); i = last + 1) {
      last = i > 0 && areJoined(last, i) ? follow(last, i, result) : i;
      result.points.push_back(points_[last]);
    }
    result.single = single_;
    return result;
  }

  /// The next point to compare with; adds those between it and `i` whose match is refuted.
  std::size_t follow(std::size_t last, std::size_t i, OdometrySelection& result) {
    const std::size_t next = nextThatAgrees(last, i, false);
    if (next != kNone) {
      if (is_counting_) single_.of(isDoubtful(next)).addAgreement();
      if (is_counting_) lasting_.of(isDoubtful(last) || isDoubtful(next)).addAgreement();
      for (std::size_t k = i; k < next; ++k) followSingle(last, k, result);
      return next;
    }
    const bool is_doubtful = isDoubtful(last) || isDoubtful(i);
    if (is_counting_) {
      lasting_.of(is_doubtful).add(sizeBetween(last, i));
    } else if (is_late_ && is_doubtful && lasting_.refutes(sizeBetween(last, i))) {
      for (const std::size_t k : {last, i})
        if (isDoubtful(k)) result.refuted[points_[k].keyframe] = true;
      return i;
    }
    // Where a scan fits at several places, its yaw is still right.
    const std::size_t turned = nextThatAgrees(last, i, true),
                      next_used = turned == kNone ? i : turned;
    if (!is_late_) weakenBetween(last, next_used, result);
    return next_used;
  }

  /// Nobody knows whether the odometry or a match is wrong: the doubtful matches lose their weight.
  void weakenBetween(std::size_t last, std::size_t next, OdometrySelection& result) const {
    for (std::size_t k = points_[last].keyframe + 1; k <= points_[next].keyframe; ++k)
      if (doubtful_[k]) result.refuted[k] = true;
  }

  void followSingle(std::size_t last, std::size_t point, OdometrySelection& result) {
    const double size = sizeBetween(last, point);
    if (is_counting_) return single_.of(isDoubtful(point)).add(size);
    if (!is_late_ || !isDoubtful(point) || !single_.refutes(size)) return;
    result.refuted[points_[point].keyframe] = true;
    result.points.push_back(points_[point]);
  }

  /// The first point from `i` on that agrees with `last`.
  std::size_t nextThatAgrees(std::size_t last, std::size_t i, bool only_yaw) const {
    const std::size_t end = std::min(points_.size(), i + kMostWrong);
    for (std::size_t next = i; next < end && areJoined(last, next); ++next)
      if (agree(points_[last], points_[next], worth_, chain_, only_yaw)) return next;
    return kNone;
  }

  /// Of the contradiction between two points.
  double sizeBetween(std::size_t a, std::size_t b) const {
    const Pose2 measured = points_[a].measured.between(points_[b].measured);
    return lengthOf(measured.between(points_[a].matched.between(points_[b].matched)));
  }
  bool areJoined(std::size_t a, std::size_t b) const {
    return chain_.partOf(points_[a].keyframe) == chain_.partOf(points_[b].keyframe);
  }
  bool isDoubtful(std::size_t point) const { return doubtful_[points_[point].keyframe]; }

  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  const std::vector<OdometryPoint>& points_;
  const OdometryWorth& worth_;
  const OdometryChain& chain_;
  const std::vector<bool>& doubtful_;
  const bool is_late_;
  Contradictions single_, lasting_;
  bool is_counting_ = true;
};

}  // namespace

double ContradictionRate::mean(double size) const {
  const auto larger =
      std::count_if(sizes_.begin(), sizes_.end(), [&](double s) { return s >= size; });
  return (static_cast<double>(larger) + 1.0) / count();
}

double ContradictionRate::sigma(double size) const {
  return std::sqrt(mean(size) * (1.0 - mean(size)) / count());
}

bool Contradictions::refutes(double contradiction) const {
  const double size = 0.5 * contradiction;  // of this order of magnitude
  return doubtful.mean(size) - doubtful.sigma(size) > 2.0 * (good.mean(size) - good.sigma(size));
}

bool agree(const OdometryPoint& a, const OdometryPoint& b, const OdometryWorth& worth,
           const OdometryChain& chain, bool only_yaw) {
  const Pose2 motion = a.measured.between(b.measured);
  const Pose2 error = motion.between(a.matched.between(b.matched));
  const Eigen::Matrix3d to_b = chain.pose(b.keyframe).inverse().adjoint();
  const Eigen::Matrix3d expected =
      Eigen::Matrix3d(varianceOf(worth, motion).asDiagonal()) +
      to_b * chain.noiseBetween(a.keyframe, b.keyframe) * to_b.transpose();
  return isExpected(only_yaw ? Pose2(0.0, 0.0, error.yaw) : error, expected);
}

OdometrySelection selectOdometry(const std::vector<OdometryPoint>& points,
                                 const OdometryWorth& worth, const OdometryChain& chain,
                                 const std::vector<bool>& doubtful, bool is_late) {
  return Selection(points, worth, chain, doubtful, is_late).run();
}

}  // namespace kestrel
