// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <istream>
#include <memory>
#include <string>

#include "kestrel_slam/recording/recording.h"

namespace kestrel {

/// Reads a table of ranges: one scan a line, ranges in m with commas between them, neither stamps
/// nor odometry; plain, .xz, .bz2 or .gz.
///
/// The number of ranges says which laser it was: 1081 a UTM-30LX (270 degrees), 681 or 682 a
/// URG-04LX. Stamps count from 0 at the rate of the options; a line that cannot be read (the last
/// one of a file that was cut off) leaves a gap.
class RangeTable : public Recording {
 public:
  /// Throws std::runtime_error where `path` cannot be read or `rate_hz` is no rate.
  RangeTable(const std::string& path, double rate_hz);

  bool next(RecordedScan& scan) override;
  std::size_t scanCount() const override { return scan_count_; }
  std::string description() const override;
  bool hasOdometry() const override { return false; }

 private:
  void survey();
  bool fill(const std::string& line, RecordedScan& scan);
  void reportCutOff();
  void skipLine(std::size_t ranges);

  std::string path_;
  double rate_hz_;
  std::unique_ptr<std::istream> stream_;
  std::size_t line_number_ = 0;
  std::size_t scan_count_ = 0;
  bool cut_off_ = false;  ///< the compressed data, and that was said
  LaserScan model_;       ///< everything but stamp and ranges
  std::size_t beams_ = 0;
};

/// Whether the file (unpacked) begins with a line of numbers with commas between them.
bool looksLikeRangeTable(const std::string& path);

}  // namespace kestrel
