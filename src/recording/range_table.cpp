// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/range_table.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/recording/fan.h"
#include "kestrel_slam/recording/text_stream.h"
#include "table_layout.h"

namespace kestrel {
namespace {

constexpr std::size_t kHeadBytes = 1U << 21U;  // hundreds of scans
constexpr double kFullTurnDeg = 360.0;
constexpr double kNanosecondsInSecond = 1e9;

std::optional<TableLayout> layoutOf(const std::string& path) {
  return findTableLayout(readHead(path, kHeadBytes));
}

void requirePositive(const std::string& path, const std::string& what, double value) {
  if (std::isfinite(value) && value > 0.0) return;
  throw std::runtime_error(path + ": a table of ranges " + what + ", not " + std::to_string(value));
}

std::string numberText(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// Sets the angles for a field of view. In a full turn an even number of beams does not repeat the
/// first one.
void setFieldOfView(double fov_deg, std::size_t beams, LaserScan& scan) {
  const bool repeats = fov_deg < kFullTurnDeg || beams % 2 == 1;
  const auto steps = static_cast<double>(std::max<std::size_t>(beams, 2) - (repeats ? 1U : 0U));
  scan.angle_min = -degToRad(fov_deg) / 2.0;
  scan.angle_increment = degToRad(fov_deg) / steps;
}

}  // namespace

bool looksLikeRangeTable(const std::string& path) { return layoutOf(path).has_value(); }

RangeTable::RangeTable(const std::string& path, const RecordingOptions& options)
    : path_(path), rate_hz_(options.rate_hz) {
  std::optional<TableLayout> layout = layoutOf(path);
  if (!layout) throw std::runtime_error(path + ": is not a table of ranges");
  layout_ = std::make_unique<const TableLayout>(std::move(*layout));
  if (!layout_->columns.stamp)
    requirePositive(path, "without stamps needs a rate above 0 Hz", rate_hz_);
  if (options.fov_deg != 0.0) {
    requirePositive(path, "needs a field of view above 0 degrees", options.fov_deg);
  }
  if (layout_->period_s > 0.0) rate_hz_ = 1.0 / layout_->period_s;
  warnings_ = layout_->warnings;
  survey();
  chooseFan(options.fov_deg);
  stream_ = openText(path_);
}

RangeTable::~RangeTable() = default;

void RangeTable::survey() {
  const std::unique_ptr<std::istream> stream = openText(path_);
  std::size_t number = 0;
  for (std::string line; readLine(*stream, line);) {
    if (++number > layout_->header_lines && !isBlank(line)) ++scan_count_;
  }
}

void RangeTable::chooseFan(double fov_deg) {
  const std::size_t beams = layout_->columns.beams;
  const Fan fan = fanOf(beams);
  model_ = scanOf(fan, beams, rate_hz_);
  laser_ = fan.laser;
  if (layout_->columns.angle_increment) return;
  if (layout_->first_angle) {
    model_.angle_min = *layout_->first_angle;
    model_.angle_increment =
        (*layout_->last_angle - *layout_->first_angle) / static_cast<double>(beams - 1);
    return;
  }
  if (fov_deg == 0.0 && fan.known) return;
  const std::string guess = layout_->full_turn
                                ? "the first and the last one see the same: 360 degrees are assumed"
                                : "270 degrees are assumed";
  if (fov_deg > 0.0 || layout_->full_turn) {
    setFieldOfView(fov_deg > 0.0 ? fov_deg : kFullTurnDeg, beams, model_);
  }
  if (fov_deg > 0.0) return;
  warnings_.push_back("a table with " + std::to_string(beams) +
                      " ranges per line does not give its field of view; " + guess +
                      ". Give it with --fov");
}

bool RangeTable::next(RecordedScan& scan) {
  std::string line;
  while (readLine(*stream_, line)) {
    if (++line_number_ <= layout_->header_lines || isBlank(line)) continue;
    if (fill(line, scan)) return true;
    skipLine(line);
  }
  if (stream_->bad()) reportCutOff();
  return false;
}

void RangeTable::reportCutOff() {
  if (cut_off_) return;
  cut_off_ = true;
  warnings_.push_back(cutOffText(line_number_));
}

bool RangeTable::fill(const std::string& line, RecordedScan& scan) {
  scan = RecordedScan();
  scan.scan = model_;
  const std::vector<std::string_view> fields = fieldsOf(line, layout_->format);
  if (fields.size() != layout_->fields || !fillHeader(fields, scan)) return false;
  const TableColumns& columns = layout_->columns;
  scan.scan.ranges.reserve(columns.beams);
  for (std::size_t i = 0; i < columns.beams; ++i) {
    double range = 0.0;
    if (!parseField(fields[columns.first_range + i], layout_->format, range)) return false;
    scan.scan.ranges.push_back(static_cast<float>(range * layout_->range_unit_m));
  }
  return true;
}

/// Everything except the ranges.
bool RangeTable::fillHeader(const std::vector<std::string_view>& fields, RecordedScan& scan) {
  const TableColumns& columns = layout_->columns;
  bool valid = true;
  const auto read = [&](const std::optional<std::size_t>& column, double& value) {
    if (column) valid = valid && parseField(fields[*column], layout_->format, value);
  };
  read(columns.angle_min, scan.scan.angle_min);
  read(columns.angle_increment, scan.scan.angle_increment);
  read(columns.time_increment, scan.scan.time_increment);
  read(columns.range_min, scan.scan.range_min);
  read(columns.range_max, scan.scan.range_max);
  double stamp = static_cast<double>(line_number_ - 1 - layout_->header_lines) / rate_hz_;
  double nanoseconds = 0.0;
  read(columns.stamp, stamp);
  read(columns.nanoseconds, nanoseconds);
  if (columns.stamp) stamp = stamp * columns.stamp_unit_s + nanoseconds / kNanosecondsInSecond;
  if (!valid || !std::isfinite(stamp)) return false;
  scan.scan.stamp = stamp;
  scan.time = columns.stamp ? monotone_time_.repair(stamp) : stamp;
  return true;
}

void RangeTable::skipLine(const std::string& line) {
  if (++skipped_["broken line"] > 1) return;
  const std::size_t fields = fieldsOf(line, layout_->format).size();
  warnings_.push_back("line " + std::to_string(line_number_) + ": broken line skipped: " +
                      (fields == layout_->fields
                           ? "a field is not a number"
                           : "it has " + std::to_string(fields) + " ranges, not " +
                                 std::to_string(layout_->fields)));
}

std::string RangeTable::description() const {
  const TableColumns& columns = layout_->columns;
  std::ostringstream text;
  text << "table of ranges, " << scan_count_ << " scans of " << columns.beams << " beams ("
       << laser_ << "), ";
  if (columns.stamp) {
    text << "stamps in column " << *columns.stamp + 1;
  } else {
    text << numberText(rate_hz_) << " Hz";
  }
  if (columns.first_range > 0) text << ", ranges from column " << columns.first_range + 1;
  if (layout_->range_unit_m != 1.0) text << ", in millimeters";
  text << ", without odometry";
  return text.str();
}

}  // namespace kestrel
