// SPDX-License-Identifier: BSD-3-Clause
#include "sweep_points.h"

#include <cmath>

namespace kestrel {
namespace {

constexpr float kLongestSweep = 0.5F;  ///< s; times beyond are wrong and not used

}  // namespace

Eigen::Matrix<double, 6, 1> rateOf(const Eigen::Isometry3d& change, double seconds) {
  const Eigen::AngleAxisd turn(change.linear());
  Eigen::Matrix<double, 6, 1> rate;
  rate << change.translation(), turn.angle() * turn.axis();
  return rate / seconds;
}

Eigen::Isometry3d changeOf(const Eigen::Matrix<double, 6, 1>& rate, double seconds) {
  Eigen::Isometry3d change = Eigen::Isometry3d::Identity();
  change.translation() = seconds * rate.head<3>();
  const double speed = rate.tail<3>().norm();
  if (speed > 0.0) {
    change.linear() = Eigen::AngleAxisd(speed * seconds, rate.tail<3>() / speed).toRotationMatrix();
  }
  return change;
}

SweepPoints usablePoints(const PointCloud& cloud, double min_range, double max_range,
                         std::size_t max_points, const Eigen::Matrix<double, 6, 1>& motion) {
  SweepPoints result;
  const std::size_t count = cloud.points.size();
  const std::size_t kept = std::min(count, max_points);
  result.thinned = kept < count;
  result.points.reserve(kept);
  result.number.reserve(kept);
  const Eigen::Vector3f velocity = motion.head<3>().cast<float>();
  const Eigen::Vector3f turn = motion.tail<3>().cast<float>();
  const float near2 = static_cast<float>(min_range * min_range);
  const float far2 = static_cast<float>(max_range * max_range);
  for (std::size_t i = 0; i < kept; ++i) {
    const std::size_t number = result.thinned ? i * count / kept : i;
    const PointCloud::Point& p = cloud.points[number];
    Eigen::Vector3f point(p.x, p.y, p.z);
    const float range2 = point.squaredNorm();
    if (!(range2 >= near2 && range2 <= far2)) continue;
    if (p.time != 0.0F && std::abs(p.time) < kLongestSweep) {
      point += p.time * (velocity + turn.cross(point));
    }
    result.points.push_back(point);
    result.number.push_back(number);
  }
  return result;
}

}  // namespace kestrel
