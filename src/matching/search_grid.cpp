// SPDX-License-Identifier: BSD-3-Clause
#include "search_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "likelihood_image.h"

namespace kestrel {
namespace {

/// Points farther than this (100 m at 5 cm) are ignored, because the image would need too much
/// memory.
constexpr float kMaxRangeCells = 2000.0F;
/// Order of the points such that every prefix is a sample of the whole scan: first every 16th beam,
/// then those halfway between them, and so on.
constexpr std::size_t kSampleStride = 16;
constexpr std::array<std::size_t, kSampleStride> kSampleOrder = {0, 8, 4, 12, 2, 10, 6, 14,
                                                                 1, 9, 5, 13, 3, 11, 7, 15};
/// Rounding tolerance, so that 0.5 m are ten cells of 5 cm and not eleven.
constexpr double kRounding = 1e-6;

int stepsOf(double window, double step) {
  return std::max(0, static_cast<int>(std::ceil(window / step - kRounding)));
}

}  // namespace

SearchGrid::SearchGrid(const SurfelField& surface, const Points& points, const Pose2& center,
                       const SearchWindow& window, const CorrelativeConfig& config)
    : center_(center), config_(config), resolution_(static_cast<double>(surface.resolution())) {
  points_.reserve(points.size());
  for (const std::size_t first : kSampleOrder) {
    for (std::size_t i = first; i < points.size(); i += kSampleStride) {
      const Eigen::Vector2f p = points[i] / surface.resolution();
      if (!(p.norm() <= kMaxRangeCells)) continue;  // also false for NaN
      points_.push_back(p);
      range_ = std::max(range_, p.norm());
    }
  }
  linear_steps_ = stepsOf(window.linear_m, resolution_);
  angular_step_ =
      std::max(config.min_angular_step_rad, static_cast<double>(1.0F / std::max(range_, 1.0F)));
  angular_steps_ = stepsOf(window.angular_rad, angular_step_);
  if (!points_.empty()) {
    score_of_one_ = 1.0 / (LikelihoodImage::kMax * static_cast<double>(points_.size()));
  }
}

CellBox SearchGrid::reach() const {
  const auto low = [this](double x) {
    return static_cast<int>(std::floor(x / resolution_ - static_cast<double>(range_))) - 1;
  };
  const auto high = [this](double x) {
    return static_cast<int>(std::floor(x / resolution_ + static_cast<double>(range_))) + 2;
  };
  return {{low(center_.x), low(center_.y)}, {high(center_.x), high(center_.y)}};
}

void SearchGrid::rotate(int k, int first, int count, const CellBox& box, PointCell* cells) const {
  const double yaw = center_.yaw + k * angular_step_;
  const auto c = static_cast<float>(std::cos(yaw)), s = static_cast<float>(std::sin(yaw));
  // Relative to the box, because floats are not accurate enough far from the origin.
  const auto x = static_cast<float>(center_.x / resolution_ - box.low.x);
  const auto y = static_cast<float>(center_.y / resolution_ - box.low.y);
  const auto width = static_cast<float>(box.high.x - box.low.x - 1);
  const auto height = static_cast<float>(box.high.y - box.low.y - 1);
  const Eigen::Vector2f* points = points_.data() + first;
  for (int i = 0; i < count; ++i) {
    const float px = x + c * points[i].x() - s * points[i].y();
    const float py = y + s * points[i].x() + c * points[i].y();
    // The values are not negative, so truncation rounds down.
    cells[i].x = static_cast<std::int32_t>(std::min(std::max(px, 0.0F), width));
    cells[i].y = static_cast<std::int32_t>(std::min(std::max(py, 0.0F), height));
  }
}

double SearchGrid::motionPenalty(const GridPose& pose, int size) const {
  const auto nearest = [size](int low) { return low > 0 ? low : std::min(0, low + size - 1); };
  const double x = nearest(pose.dx), y = nearest(pose.dy);
  return config_.linear_preference * resolution_ * std::sqrt(x * x + y * y) +
         config_.angular_preference * std::abs(pose.k * angular_step_);
}

Pose2 SearchGrid::pose(const GridPose& at) const {
  return {center_.x + at.dx * resolution_, center_.y + at.dy * resolution_,
          center_.yaw + at.k * angular_step_};
}

}  // namespace kestrel
