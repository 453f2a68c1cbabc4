// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/range_table.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/recording/fan.h"
#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

constexpr std::size_t kMinBeams = 8;  // a line with fewer numbers is not a scan

std::size_t beamsIn(const std::string& line) {
  return 1 + static_cast<std::size_t>(std::count(line.begin(), line.end(), ','));
}

bool isBlank(const std::string& line) {
  return line.find_first_not_of(" \t\r") == std::string::npos;
}

/// Parses comma-separated numbers, including `nan` and `inf`; false if the line has anything else.
bool parseRanges(const std::string& line, std::vector<float>& ranges) {
  ranges.clear();
  const char* at = line.c_str();
  while (true) {
    char* end = nullptr;
    ranges.push_back(std::strtof(at, &end));
    if (end == at) return false;
    while (*end == ' ' || *end == '\t' || *end == '\r') ++end;
    if (*end == '\0') return end == line.c_str() + line.size();
    if (*end != ',') return false;
    at = end + 1;
  }
}

}  // namespace

bool looksLikeRangeTable(const std::string& path) {
  std::istringstream head(readHead(path));
  std::vector<float> ranges;
  for (std::string line; std::getline(head, line);) {
    if (isBlank(line)) continue;
    return beamsIn(line) >= kMinBeams && parseRanges(line, ranges);
  }
  return false;
}

RangeTable::RangeTable(const std::string& path, double rate_hz) : path_(path), rate_hz_(rate_hz) {
  if (!std::isfinite(rate_hz) || rate_hz <= 0.0) {
    throw std::runtime_error(
        path + ": a table of ranges has no stamps, so it needs a rate above 0 Hz, not " +
        std::to_string(rate_hz));
  }
  survey();
  stream_ = openText(path_);
}

void RangeTable::survey() {
  const std::unique_ptr<std::istream> stream = openText(path_);
  for (std::string line; std::getline(*stream, line);) {
    if (isBlank(line)) continue;
    if (beams_ == 0) beams_ = beamsIn(line);
    ++scan_count_;
  }
  const Fan fan = fanOf(beams_);
  model_ = scanOf(fan, beams_, rate_hz_);
  if (fan.known) return;
  warnings_.push_back("a table with " + std::to_string(beams_) +
                      " ranges per line does not give its field of view: 270 degrees are assumed");
}

bool RangeTable::next(RecordedScan& scan) {
  std::string line;
  while (std::getline(*stream_, line)) {
    ++line_number_;
    if (isBlank(line)) continue;
    if (fill(line, scan)) return true;
    skipLine(beamsIn(line));
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
  if (!parseRanges(line, scan.scan.ranges) || scan.scan.ranges.size() != beams_) return false;
  scan.scan.stamp = scan.time = static_cast<double>(line_number_ - 1) / rate_hz_;
  return true;
}

void RangeTable::skipLine(std::size_t ranges) {
  if (++skipped_["broken line"] > 1) return;
  warnings_.push_back("line " + std::to_string(line_number_) + ": broken line skipped: " +
                      (ranges == beams_ ? "a field is not a number"
                                        : "it has " + std::to_string(ranges) + " ranges, not " +
                                              std::to_string(beams_)));
}

std::string RangeTable::description() const {
  std::ostringstream text;
  text << "table of ranges, " << scan_count_ << " scans of " << beams_ << " beams ("
       << fanOf(beams_).laser << "), " << rate_hz_ << " Hz, without odometry";
  return text.str();
}

}  // namespace kestrel
