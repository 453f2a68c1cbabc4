// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cairo.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/report/geotiff.h"

namespace kestrel {

/// The picture of a GeoTIFF.
class GeotiffPicture {
 public:
  /// Throws std::runtime_error if the map is empty or too large.
  explicit GeotiffPicture(const GeotiffContent& content);

  int width() const { return width_; }
  int height() const { return height_; }
  double metersPerPixel() const { return 1.0 / pixels_per_m_; }
  /// Map coordinates of the upper left corner of the picture.
  const Eigen::Vector2d& corner() const { return corner_; }

  /// Red, green and blue of the pixels of a row.
  std::vector<std::uint8_t> row(int y) const;

 private:
  using Color = std::uint32_t;  ///< 0xRRGGBB

  void drawCells();
  Color colorAt(const Eigen::Vector2d& point) const;
  Color freeColorAt(const Eigen::Vector2d& point) const;
  void drawPath();
  void drawStart(const Pose2& start);
  void drawMark(const GeotiffMark& mark);
  void drawScale();
  void drawArrow(double x, double y, double to_x, double to_y);
  void drawText(const std::string& text, double x, double y, double size);
  void setColor(Color color);
  Eigen::Vector2d pixelOf(const Eigen::Vector2d& point) const;

  const GeotiffContent& content_;
  double pixels_per_m_ = 1.0;
  int width_ = 0, height_ = 0;
  Eigen::Vector2d corner_;
  std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface_;
  std::unique_ptr<cairo_t, decltype(&cairo_destroy)> cairo_;
};

}  // namespace kestrel
