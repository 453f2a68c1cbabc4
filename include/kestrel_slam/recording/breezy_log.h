// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <istream>
#include <memory>
#include <optional>
#include <string>

#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/sensor/time_base.h"

namespace kestrel {

/// Reads a log of the Mines ParisTech rover in the format of BreezySLAM and CoreSLAM: one scan per
/// line, as numbers separated by spaces. Column 1 is the time in µs. Columns 3 and 4 are the
/// encoder ticks of the left and the right wheel. Columns 25 to 706 are the ranges of a URG-04LX in
/// mm; 0 means no reading. The file may be plain text, .xz, .bz2 or .gz.
class BreezyLog : public Recording {
 public:
  /// Throws std::runtime_error if `path` cannot be read.
  explicit BreezyLog(const std::string& path);

  bool next(RecordedScan& scan) override;
  std::size_t scanCount() const override { return scan_count_; }
  std::string description() const override;
  bool hasOdometry() const override { return true; }

 private:
  bool fill(const std::string& line, RecordedScan& scan);
  void reportCutOff();
  void drive(const std::array<double, 2>& ticks);

  std::string path_;
  std::unique_ptr<std::istream> stream_;
  std::size_t line_number_ = 0;
  std::size_t scan_count_ = 0;
  bool cut_off_ = false;     ///< the compressed data are cut off, and the warning is given
  std::size_t columns_ = 0;  ///< of nearly all lines; 0: the lines differ
  std::optional<std::array<double, 2>> seen_ticks_;  ///< of the last line, also if it was skipped
  std::optional<std::array<double, 2>> last_ticks_;  ///< of the left and the right wheel
  Pose2 odom_T_base_;
  MonotoneTime monotone_time_;
};

/// True if the first line of the (decompressed) file has the columns of such a log.
bool looksLikeBreezyLog(const std::string& path);

}  // namespace kestrel
