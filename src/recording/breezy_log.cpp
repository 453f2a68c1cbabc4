// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/breezy_log.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/recording/fan.h"
#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

// Columns, counted from 0.
constexpr std::size_t kTime = 0, kLeftTicks = 2, kRightTicks = 3, kFirstRange = 24;
constexpr std::size_t kBeams = 682;
constexpr std::size_t kFewestColumns = kFirstRange + kBeams, kMostColumns = kFewestColumns + 1;
constexpr double kMicrosecondsPerSecond = 1e6;  // used as divisor, so that a stamp is rounded once
constexpr double kMillimetersPerMeter = 1e3;
constexpr double kRateHz = 10.0;  // of a URG-04LX

// The rover, as documented in BreezySLAM (examples/mines.py).
constexpr double kWheelRadius = 0.077, kHalfAxle = 0.165, kLaserX = 0.145;  // m
constexpr double kTicksPerTurn = 2000.0;

/// The numbers of a line; empty if a field is not a number.
std::vector<double> columnsOf(const std::string& line) {
  std::istringstream fields(line);
  std::vector<double> columns;
  columns.reserve(kMostColumns);
  double value = 0.0;
  for (std::string field; fields >> field;) {
    if (!parseFinite(field, value)) return {};
    columns.push_back(value);
  }
  return columns;
}

bool isScan(const std::vector<double>& columns) {
  return columns.size() >= kFewestColumns && columns.size() <= kMostColumns;
}

std::size_t countColumns(const std::string& line) {
  std::istringstream fields(line);
  std::size_t count = 0;
  for (std::string field; fields >> field;) ++count;
  return count;
}

constexpr double kMetersPerTick = 2.0 * kPi * kWheelRadius / kTicksPerTurn;

/// A rover does not drive so far between two scans; a damaged digit looks so.
bool isJump(const std::array<double, 2>& from, const std::array<double, 2>& to) {
  constexpr double kMaxStep = 2.0;  // m
  return kMetersPerTick * std::max(std::abs(to[0] - from[0]), std::abs(to[1] - from[1])) > kMaxStep;
}

}  // namespace

bool looksLikeBreezyLog(const std::string& path) {
  std::istringstream head(readHead(path));
  std::string line;
  return std::getline(head, line) && isScan(columnsOf(line));
}

BreezyLog::BreezyLog(const std::string& path) : path_(path) {
  const std::unique_ptr<std::istream> stream = openText(path_);
  std::map<std::size_t, std::size_t> lines;  // by number of columns
  for (std::string line; readLine(*stream, line);) {
    const std::size_t columns = countColumns(line);
    if (columns == 0) continue;
    ++scan_count_;
    ++lines[columns];
  }
  for (const auto& [columns, count] : lines) {
    if (10 * count >= 9 * scan_count_) columns_ = columns;
  }
  stream_ = openText(path_);
}

bool BreezyLog::next(RecordedScan& scan) {
  for (std::string line; readLine(*stream_, line);) {
    ++line_number_;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    if (fill(line, scan)) return true;
    if (++skipped_["broken line"] > 1) continue;
    warnings_.push_back("line " + std::to_string(line_number_) + ": broken line skipped: a scan " +
                        "has " + std::to_string(columns_ > 0 ? columns_ : kFewestColumns) +
                        " numbers, and the wheels do not jump");
  }
  if (stream_->bad()) reportCutOff();
  return false;
}

void BreezyLog::reportCutOff() {
  if (cut_off_) return;
  cut_off_ = true;
  warnings_.push_back(cutOffText(line_number_));
}

bool BreezyLog::fill(const std::string& line, RecordedScan& scan) {
  const std::vector<double> columns = columnsOf(line);
  if (!isScan(columns) || (columns_ > 0 && columns.size() != columns_)) return false;
  const std::array<double, 2> ticks = {columns[kLeftTicks], columns[kRightTicks]};
  const bool jumps = last_ticks_ && isJump(*last_ticks_, ticks);
  const bool stays = seen_ticks_ && !isJump(*seen_ticks_, ticks);
  seen_ticks_ = ticks;
  if (jumps && !stays) return false;
  if (jumps) last_ticks_ = ticks;  // the encoders were reset
  drive(ticks);
  scan = RecordedScan();
  scan.scan = scanOf(fanOf(kBeams), kBeams, kRateHz);
  scan.scan.stamp = columns[kTime] / kMicrosecondsPerSecond;
  scan.time = monotone_time_.repair(scan.scan.stamp);
  scan.base_T_laser.translation().x() = kLaserX;
  scan.odom_T_base = odom_T_base_;
  for (std::size_t i = 0; i < kBeams; ++i) {
    const double mm = columns[kFirstRange + i];
    scan.scan.ranges.push_back(mm == 0.0 ? std::numeric_limits<float>::quiet_NaN()
                                         : static_cast<float>(mm / kMillimetersPerMeter));
  }
  return true;
}

/// Dead reckoning of a differential drive, along the chord of each arc.
void BreezyLog::drive(const std::array<double, 2>& ticks) {
  if (last_ticks_) {
    const double left = kMetersPerTick * (ticks[0] - (*last_ticks_)[0]);
    const double right = kMetersPerTick * (ticks[1] - (*last_ticks_)[1]);
    const double turn = (right - left) / (2.0 * kHalfAxle);
    const double distance = (left + right) / 2.0;
    odom_T_base_ = odom_T_base_ *
                   Pose2(distance * std::cos(turn / 2.0), distance * std::sin(turn / 2.0), turn);
  }
  last_ticks_ = ticks;
}

std::string BreezyLog::description() const {
  return "BreezySLAM log, " + std::to_string(scan_count_) +
         " scans of a URG-04LX, with wheel odometry";
}

}  // namespace kestrel
