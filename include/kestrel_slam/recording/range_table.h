// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <istream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/sensor/time_base.h"

namespace kestrel {

struct TableLayout;

/// Reads a table of ranges: one scan per line. The layout is found from the first lines: commas,
/// semicolons or blanks between the ranges, decimal commas, header lines, columns with row numbers
/// and stamps, m or mm, and what `rostopic echo -p` and `ros2 topic echo --csv` write. The file may
/// be plain text, .xz, .bz2 or .gz.
///
/// Without angles in the table, its number of ranges determines the laser: 1081 is a UTM-30LX (270
/// degrees), 681 or 682 is a URG-04LX. Without stamps they start at 0 and increase at the given
/// rate. A line that cannot be read (as the last line of a file that was cut off) leaves a gap.
class RangeTable : public Recording {
 public:
  /// Throws std::runtime_error if `path` cannot be read or an option is not positive and finite.
  RangeTable(const std::string& path, const RecordingOptions& options);
  ~RangeTable() override;

  bool next(RecordedScan& scan) override;
  std::size_t scanCount() const override { return scan_count_; }
  std::string description() const override;
  bool hasOdometry() const override { return false; }

 private:
  void survey();
  void chooseFan(double fov_deg);
  bool fill(const std::string& line, RecordedScan& scan);
  bool fillHeader(const std::vector<std::string_view>& fields, RecordedScan& scan);
  void reportCutOff();
  void skipLine(const std::string& line);

  std::string path_;
  std::unique_ptr<const TableLayout> layout_;
  double rate_hz_;
  std::unique_ptr<std::istream> stream_;
  std::size_t line_number_ = 0;
  std::size_t scan_count_ = 0;
  bool cut_off_ = false;  ///< the compressed data are cut off, and the warning is given
  LaserScan model_;       ///< everything except stamp and ranges
  std::string laser_;     ///< its name and field of view
  MonotoneTime monotone_time_;
};

/// True if the (decompressed) file begins with a table of ranges.
bool looksLikeRangeTable(const std::string& path);

}  // namespace kestrel
