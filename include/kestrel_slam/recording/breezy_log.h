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

/// Reads a log of the Mines ParisTech rover in the format of BreezySLAM and CoreSLAM: numbers with
/// spaces between them, one scan a line. Column 1 is the time in µs, columns 3 and 4 the ticks of
/// the left and the right wheel, columns 25 to 706 the ranges of a URG-04LX in mm, 0 where it has
/// no reading. Plain, .xz, .bz2 or .gz.
class BreezyLog : public Recording {
 public:
  /// Throws std::runtime_error where `path` cannot be read.
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
  bool cut_off_ = false;                             ///< the compressed data, and that was said
  std::optional<std::array<double, 2>> last_ticks_;  ///< of the left and the right wheel
  Pose2 odom_T_base_;
  MonotoneTime monotone_time_;
};

/// Whether the first line of the file (unpacked) has the columns of such a log.
bool looksLikeBreezyLog(const std::string& path);

}  // namespace kestrel
