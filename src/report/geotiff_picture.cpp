// SPDX-License-Identifier: BSD-3-Clause
#include "geotiff_picture.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

// Colors of the rules of the RoboCup Rescue league.
constexpr std::uint32_t kDarkTile = 0xE2E2E3, kLightTile = 0xEDEDEE, kExplored = 0xFFFFFF,
                        kGrid = 0xBEBEBF, kWall = 0x002878, kPathColor = 0x78008C,
                        kStart = 0xFFC800, kVictim = 0xF00A0A, kHazard = 0xFF641E, kQr = 0x0A0AF0,
                        kOther = 0x505050, kScale = 0x00328C, kTitle = 0x002CCF, kGray = 0x808080,
                        kWhite = 0xFFFFFF;
constexpr double kTile = 1.0, kGridStep = 0.5, kMarkRadius = 0.175;  // m
constexpr double kWideMargin = 3.0, kNarrowMargin = 1.0;             // m; the scale is above left
constexpr int kPixelsPerCell = 3, kMaxSide = 30000;                  // pixels; the limit of cairo
constexpr double kPathWidth = 3.0, kTextHeight = 18.0;               // pixels

/// Pixels per cell: fewer for a large map.
int scaleFor(const MapSnapshot& map) {
  const int margins = static_cast<int>(std::ceil(kWideMargin / map.resolution_m) +
                                       std::ceil(kNarrowMargin / map.resolution_m));
  const int side = std::max(map.width, map.height) + margins;
  const int scale = std::min(kPixelsPerCell, kMaxSide / side);
  if (map.empty()) throw std::runtime_error("the map is empty");
  if (scale < 1) throw std::runtime_error("the map is too large for one picture");
  return scale;
}

bool isOdd(double number) { return std::fmod(std::abs(number), 2.0) >= 1.0; }

}  // namespace

GeotiffPicture::GeotiffPicture(const GeotiffContent& content)
    : content_(content),
      surface_(nullptr, &cairo_surface_destroy),
      cairo_(nullptr, &cairo_destroy) {
  const MapSnapshot& map = content.map;
  const int scale = scaleFor(map);
  pixels_per_m_ = scale / map.resolution_m;
  // Margins of whole cells: so every cell has the same number of pixels.
  const int wide = static_cast<int>(std::ceil(kWideMargin / map.resolution_m));
  const int narrow = static_cast<int>(std::ceil(kNarrowMargin / map.resolution_m));
  width_ = scale * (map.height + wide + narrow);
  height_ = scale * (map.width + wide + narrow);
  corner_ = Eigen::Vector2d(map.origin_x + (map.width + wide) * map.resolution_m,
                            map.origin_y + (map.height + wide) * map.resolution_m);
  surface_.reset(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width_, height_));
  cairo_.reset(cairo_create(surface_.get()));
  if (cairo_status(cairo_.get()) != CAIRO_STATUS_SUCCESS) {
    throw std::runtime_error("there is not enough memory for the picture");
  }
  drawCells();
  drawPath();
  for (const GeotiffMark& mark : content.marks) drawMark(mark);
  drawScale();
  cairo_surface_flush(surface_.get());
}

std::vector<std::uint8_t> GeotiffPicture::row(int y) const {
  const auto* pixels = reinterpret_cast<const std::uint32_t*>(
      cairo_image_surface_get_data(surface_.get()) +
      static_cast<std::ptrdiff_t>(y) * cairo_image_surface_get_stride(surface_.get()));
  std::vector<std::uint8_t> bytes;
  bytes.reserve(3U * static_cast<std::size_t>(width_));
  for (int x = 0; x < width_; ++x) {
    for (const unsigned int shift : {16U, 8U, 0U}) {
      bytes.push_back(static_cast<std::uint8_t>(pixels[x] >> shift));
    }
  }
  return bytes;
}

void GeotiffPicture::drawCells() {
  const int stride = cairo_image_surface_get_stride(surface_.get());
  unsigned char* const data = cairo_image_surface_get_data(surface_.get());
  for (int y = 0; y < height_; ++y) {
    auto* pixels = reinterpret_cast<Color*>(data + static_cast<std::ptrdiff_t>(y) * stride);
    for (int x = 0; x < width_; ++x) {
      pixels[x] = colorAt(corner_ - Eigen::Vector2d(y + 0.5, x + 0.5) / pixels_per_m_);
    }
  }
  cairo_surface_mark_dirty(surface_.get());
}

GeotiffPicture::Color GeotiffPicture::colorAt(const Eigen::Vector2d& point) const {
  const MapSnapshot& map = content_.map;
  const auto column = static_cast<int>(std::floor((point.x() - map.origin_x) / map.resolution_m));
  const auto row = static_cast<int>(std::floor((point.y() - map.origin_y) / map.resolution_m));
  if (column >= 0 && row >= 0 && column < map.width && row < map.height) {
    const std::int8_t value = map.at(column, row);
    if (value == MapSnapshot::kOccupied) return kWall;
    if (value == MapSnapshot::kFree) return freeColorAt(point);
  }
  if (!content_.checkerboard) return kGray;
  return isOdd(std::floor(point.x() / kTile) + std::floor(point.y() / kTile)) ? kLightTile
                                                                              : kDarkTile;
}

/// The lines of the grid are one pixel wide.
GeotiffPicture::Color GeotiffPicture::freeColorAt(const Eigen::Vector2d& point) const {
  const auto isLine = [this](double value) {
    return std::floor(value / kGridStep) != std::floor((value - 1.0 / pixels_per_m_) / kGridStep);
  };
  return content_.grid && (isLine(point.x()) || isLine(point.y())) ? kGrid : kExplored;
}

void GeotiffPicture::drawPath() {
  if (content_.path.empty()) return;
  setColor(kPathColor);
  cairo_set_line_width(cairo_.get(), kPathWidth);
  for (const Pose2& pose : content_.path) {
    const Eigen::Vector2d pixel = pixelOf(Eigen::Vector2d(pose.x, pose.y));
    cairo_line_to(cairo_.get(), pixel.x(), pixel.y());
  }
  cairo_stroke(cairo_.get());
  drawStart(content_.path.front());
}

/// An arrow head that points to where the vehicle looked.
void GeotiffPicture::drawStart(const Pose2& start) {
  constexpr double kTip = 0.3, kBack = 0.15;  // m
  setColor(kStart);
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(kTip, 0.0), Eigen::Vector2d(-kBack, -kBack), Eigen::Vector2d(0.0, 0.0),
        Eigen::Vector2d(-kBack, kBack)}) {
    const Eigen::Vector2d pixel = pixelOf(start * corner);
    cairo_line_to(cairo_.get(), pixel.x(), pixel.y());
  }
  cairo_close_path(cairo_.get());
  cairo_fill(cairo_.get());
}

void GeotiffPicture::drawMark(const GeotiffMark& mark) {
  const Eigen::Vector2d center = pixelOf(mark.position);
  const double radius = kMarkRadius * pixels_per_m_;
  cairo_new_path(cairo_.get());
  if (mark.kind == GeotiffMark::Kind::kHazard) {
    const double half = radius * std::sqrt(2.0);
    for (const auto& [x, y] : {std::pair{half, 0.0}, {0.0, half}, {-half, 0.0}, {0.0, -half}}) {
      cairo_line_to(cairo_.get(), center.x() + x, center.y() + y);
    }
  } else {
    cairo_arc(cairo_.get(), center.x(), center.y(), radius, 0.0, 2.0 * kPi);
  }
  const bool is_victim = mark.kind == GeotiffMark::Kind::kVictim;
  const bool is_hazard = mark.kind == GeotiffMark::Kind::kHazard;
  const bool is_qr = mark.kind == GeotiffMark::Kind::kQr;
  setColor(is_victim ? kVictim : is_hazard ? kHazard : is_qr ? kQr : kOther);
  cairo_fill(cairo_.get());
  setColor(kWhite);
  drawText(mark.text, center.x(), center.y(), mark.text.size() < 2 ? kTextHeight : kTextHeight / 2);
}

/// A bar of 1 m, the axes of the map, and the title.
void GeotiffPicture::drawScale() {
  const double m = pixels_per_m_;
  setColor(kScale);
  cairo_set_line_width(cairo_.get(), 1.0);
  for (const double y : {m, 2.0 * m}) {
    cairo_move_to(cairo_.get(), 0.4 * m, y);
    cairo_line_to(cairo_.get(), 0.6 * m, y);
  }
  cairo_move_to(cairo_.get(), 0.5 * m, m);
  cairo_line_to(cairo_.get(), 0.5 * m, 2.0 * m);
  drawArrow(2.0 * m, 2.0 * m, 2.0 * m, m);
  drawArrow(2.0 * m, 2.0 * m, m, 2.0 * m);
  cairo_stroke(cairo_.get());
  drawText("1m", 0.8 * m, 1.5 * m, kTextHeight);
  drawText("x", 2.3 * m, 1.1 * m, kTextHeight);
  drawText("y", 1.2 * m, 1.75 * m, kTextHeight);
  setColor(kTitle);
  cairo_move_to(cairo_.get(), 0.5 * m, 0.6 * m);
  cairo_show_text(cairo_.get(), content_.title.c_str());
}

void GeotiffPicture::drawArrow(double x, double y, double to_x, double to_y) {
  constexpr double kHead = 0.15;
  const Eigen::Vector2d to(to_x, to_y), back = kHead * (Eigen::Vector2d(x, y) - to);
  const Eigen::Vector2d side(-back.y(), back.x());
  cairo_move_to(cairo_.get(), x, y);
  cairo_line_to(cairo_.get(), to.x(), to.y());
  for (const Eigen::Vector2d& end :
       {Eigen::Vector2d(to + back + side), Eigen::Vector2d(to + back - side)}) {
    cairo_move_to(cairo_.get(), to.x(), to.y());
    cairo_line_to(cairo_.get(), end.x(), end.y());
  }
}

/// Centered at the pixel.
void GeotiffPicture::drawText(const std::string& text, double x, double y, double size) {
  if (text.empty()) return;
  cairo_text_extents_t extents{};
  cairo_set_font_size(cairo_.get(), size);
  cairo_text_extents(cairo_.get(), text.c_str(), &extents);
  cairo_move_to(cairo_.get(), x - extents.x_bearing - extents.width / 2.0,
                y - extents.y_bearing - extents.height / 2.0);
  cairo_show_text(cairo_.get(), text.c_str());
}

void GeotiffPicture::setColor(Color color) {
  constexpr double kFull = 255.0;
  cairo_set_source_rgb(cairo_.get(), (color >> 16U & 0xffU) / kFull, (color >> 8U & 0xffU) / kFull,
                       (color & 0xffU) / kFull);
}

Eigen::Vector2d GeotiffPicture::pixelOf(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d down_right = (corner_ - point) * pixels_per_m_;
  return {down_right.y(), down_right.x()};
}

}  // namespace kestrel
