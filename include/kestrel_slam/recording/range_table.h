// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <istream>
#include <memory>
#include <string>

#include "kestrel_slam/recording/recording.h"

namespace kestrel {

/// Reads a table of ranges: one scan per line, ranges in m separated by commas, without stamps and
/// odometry. The file may be plain text, .xz, .bz2 or .gz.
///
/// The number of ranges determines the laser: 1081 is a UTM-30LX (270 degrees), 681 or 682 is a
/// URG-04LX. Stamps start at 0 and increase at the given rate. A line that cannot be read (as the
/// last line of a file that was cut off) leaves a gap.
class RangeTable : public Recording {
 public:
  /// Throws std::runtime_error if `path` cannot be read or `rate_hz` is not positive and finite.
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
  bool cut_off_ = false;  ///< the compressed data are cut off, and the warning is given
  LaserScan model_;       ///< everything except stamp and ranges
  std::size_t beams_ = 0;
};

/// True if the (decompressed) file begins with a line of comma-separated numbers.
bool looksLikeRangeTable(const std::string& path);

}  // namespace kestrel
