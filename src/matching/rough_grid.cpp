// SPDX-License-Identifier: BSD-3-Clause
#include "rough_grid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/matching/thinned.h"

namespace kestrel {
namespace {

/// Number of points for a search.
constexpr std::size_t kRoughPoints = 96;
/// Points farther than this are ignored, because the image would be large.
constexpr float kRoughFarthestM = 100.0F;
/// Limits of the angular step for pixels of 20 cm, rad.
constexpr double kLeastStep = 0.025, kMostStep = 0.07, kPixelM = 0.2;
/// Number of points that are summed in bytes.
constexpr std::size_t kRoughTogether = 4;
static_assert(kRoughTogether * WallImage::kWall <= 0xFF, "the sum of four fits into a byte");
static_assert(kRoughPoints * WallImage::kWall <= 0x7FFF, "the sum of all points fits");
/// Work of one rotated point, and of a row of windows for four points.
constexpr std::int64_t kWorkPerRotation = 20, kWorkPerRoughRow = 16, kWorkPerPart = 1000;

/// A row of pixels, for all poses of a row of a part. The rows are local variables: the compiler
/// knows that they overlap with nothing, and uses vector instructions.
constexpr int kSide = RoughPart::kSide;
using PixelRow = std::array<std::uint8_t, kSide>;

/// The sum of the rows of four points.
inline PixelRow sumOfFour(const std::uint8_t* const* points, std::ptrdiff_t offset) {
  const std::uint8_t *a = points[0] + offset, *b = points[1] + offset, *c = points[2] + offset,
                     *d = points[3] + offset;
  PixelRow result;
  for (std::size_t i = 0; i < kSide; ++i)
    result[i] = static_cast<std::uint8_t>(a[i] + b[i] + c[i] + d[i]);
  return result;
}

inline void addRow(const PixelRow& a, const PixelRow& b, std::int16_t* sum) {
  for (std::size_t i = 0; i < kSide; ++i) sum[i] = static_cast<std::int16_t>(sum[i] + a[i] + b[i]);
}

/// `kRoughPoints` points of the scan, evenly distributed over the beams.
Points sampleOf(const Points& points) {
  Points near;
  for (const Eigen::Vector2f& p : points) {
    if (p.norm() <= kRoughFarthestM) near.push_back(p);  // false for NaN
  }
  return sampled(near, kRoughPoints);
}

float medianRange(const Points& points) {
  std::vector<float> ranges;
  for (const Eigen::Vector2f& p : points) ranges.push_back(p.norm());
  const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::nth_element(ranges.begin(), middle, ranges.end());
  return *middle;
}

/// The layer for a point that one half of an angular step moves by `pixels`.
int layerFor(double pixels) {
  int layer = 0;
  for (double reach = 0.75; pixels > reach && layer + 1 < WallImage::kMostLayers; reach *= 2.0)
    ++layer;
  return layer;
}

/// Extends `box` by the arc of a point that is rotated by `yaw` ± `turn`, rad.
void extendByArc(const Eigen::Vector2f& point, double yaw, double turn, Eigen::AlignedBox2d& box) {
  const auto range = static_cast<double>(point.norm());
  const double middle =
      yaw + std::atan2(static_cast<double>(point.y()), static_cast<double>(point.x()));
  const auto extend = [&](double angle) {
    box.extend(Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle)));
  };
  extend(middle - turn);
  extend(middle + turn);
  for (int quarter = 0; quarter < 4; ++quarter) {
    const double extreme = quarter * 0.5 * kPi;
    if (std::abs(normalizeAngle(extreme - middle)) <= turn) extend(extreme);
  }
}

}  // namespace

RoughGrid::RoughGrid(const SurfelField& surface, const Points& points, const RoughWindow& window,
                     int shift)
    : window_(window), shift_(shift) {
  const auto cell_m = static_cast<double>(surface.resolution());
  pixel_m_ = cell_m * (1 << shift);
  linear_steps_ = static_cast<int>(std::ceil(window.size.linear_m / pixel_m_ - 1e-6));
  const Points sample = sampleOf(points);
  if (sample.empty()) return;
  const double share = pixel_m_ / kPixelM;
  const auto median = static_cast<double>(medianRange(sample));
  angular_step_ =
      std::clamp(pixel_m_ / std::max(median, 1e-3), kLeastStep * share, kMostStep * share);
  angular_steps_ = static_cast<int>(std::ceil(window.size.angular_rad / angular_step_ - 1e-6));
  Eigen::AlignedBox2d reached;  // relative to the center of the window, m
  for (const Eigen::Vector2f& p : sample) {
    const auto r = static_cast<double>(p.norm());
    extendByArc(p, window.center.yaw, angular_steps_ * angular_step_, reached);
    const int layer = layerFor(0.5 * angular_step_ * r / pixel_m_);
    layers_ = std::max(layers_, layer + 1);
    const Eigen::Vector2f place = p / static_cast<float>(pixel_m_);
    x_.push_back(place.x());
    y_.push_back(place.y());
    layer_of_.push_back(layer);
  }
  pixels_.resize(layer_of_.size());
  score_of_one_ = 1.0 / (WallImage::kWall * static_cast<double>(layer_of_.size()));
  // One more block of columns may be read beside the window.
  const double reach = (linear_steps_ + RoughPart::kSide + 2) * pixel_m_;
  const auto cell = [&](double x) { return static_cast<int>(std::floor(x / cell_m)); };
  const Pose2& center = window.center;
  box_ = {{cell(center.x + reached.min().x() - reach), cell(center.y + reached.min().y() - reach)},
          {cell(center.x + reached.max().x() + reach), cell(center.y + reached.max().y() + reach)}};
}

Pose2 RoughGrid::pose(int k, int dx, int dy) const {
  return {window_.center.x + dx * pixel_m_, window_.center.y + dy * pixel_m_,
          window_.center.yaw + k * angular_step_};
}

void RoughGrid::rotate(const WallImage& image, int k) {
  stride_ = image.stride();
  const double yaw = window_.center.yaw + k * angular_step_;
  const auto c = static_cast<float>(std::cos(yaw)), s = static_cast<float>(std::sin(yaw));
  const double cell_m = pixel_m_ / image.cellsPerPixel();
  // Relative to the image, because floats are not accurate enough far from the origin.
  const auto x = static_cast<float>((window_.center.x - image.corner().x * cell_m) / pixel_m_);
  const auto y = static_cast<float>((window_.center.y - image.corner().y * cell_m) / pixel_m_);
  // A loop of its own for the arithmetic, so that the compiler uses vector instructions.
  std::array<std::int32_t, kRoughPoints> columns, rows;
  for (std::size_t i = 0; i < layer_of_.size(); ++i) {
    columns[i] = static_cast<std::int32_t>(x + c * x_[i] - s * y_[i]);
    rows[i] = static_cast<std::int32_t>(y + s * x_[i] + c * y_[i]);
  }
  for (std::size_t i = 0; i < layer_of_.size(); ++i) {
    pixels_[i] =
        image.layer(layer_of_[i]) + static_cast<std::ptrdiff_t>(rows[i]) * stride_ + columns[i];
  }
}

void RoughGrid::sum(const RoughPart& part, Sums& sums) const {
  std::fill_n(sums.begin(), part.rows * kSide, std::int16_t{0});
  const std::ptrdiff_t offset = static_cast<std::ptrdiff_t>(part.dy) * stride_ + part.dx;
  std::size_t n = 0;
  // Each row of sums is read and written once for eight points.
  for (; n + 2 * kRoughTogether <= pixels_.size(); n += 2 * kRoughTogether) {
    std::ptrdiff_t at = offset;
    std::int16_t* sum = sums.data();
    for (int row = 0; row < part.rows; ++row, at += stride_, sum += kSide)
      addRow(sumOfFour(&pixels_[n], at), sumOfFour(&pixels_[n + kRoughTogether], at), sum);
  }
  for (; n < pixels_.size(); ++n) {
    const std::uint8_t* a = pixels_[n] + offset;
    std::int16_t* sum = sums.data();
    for (int row = 0; row < part.rows; ++row, a += stride_, sum += kSide) {
      PixelRow pixels;
      std::copy_n(a, kSide, pixels.begin());
      addRow(pixels, PixelRow{}, sum);
    }
  }
}

std::int64_t RoughGrid::imageWork() const { return WallImage::workFor(box_, shift_, layers_); }

std::shared_ptr<const WallImage> RoughGrid::imageOf(const SurfelField& surface) const {
  return std::make_shared<const WallImage>(surface, box_, shift_, layers_);
}

bool RoughGrid::isIn(const WallImage* image) const {
  return image != nullptr && image->covers(box_, shift_, layers_);
}

std::int64_t RoughGrid::rotationWork() const {
  return kWorkPerRotation * static_cast<std::int64_t>(layer_of_.size());
}

std::int64_t RoughGrid::sumWork(const RoughPart& part) const {
  const auto additions =
      static_cast<std::int64_t>(layer_of_.size() / kRoughTogether + kRoughTogether);
  return kWorkPerPart + kWorkPerRoughRow * additions * part.rows;
}

}  // namespace kestrel
