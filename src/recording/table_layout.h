// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kestrel {

/// How the fields of a line are separated.
struct TableFormat {
  char separator = ',';        ///< ' ' stands for any number of blanks
  bool decimal_comma = false;  ///< 4,003 instead of 4.003
};

/// The format of a line with many numbers.
TableFormat formatOf(const std::string& line);

/// The fields of a line without surrounding blanks. A separator at the end of the line adds none.
std::vector<std::string_view> fieldsOf(const std::string& line, const TableFormat& format);

/// Parses a number, `nan` or `inf`; false if the field is anything else.
bool parseField(std::string_view field, const TableFormat& format, double& value);

bool isBlank(const std::string& line);

/// The columns of a table of ranges, counted from 0.
struct TableColumns {
  std::size_t first_range = 0, beams = 0;
  std::optional<std::size_t> stamp, nanoseconds;
  double stamp_unit_s = 1.0;
  // Only in tables with the fields of a LaserScan message.
  std::optional<std::size_t> angle_min, angle_increment, time_increment, range_min, range_max;
};

/// How a table of ranges is written.
struct TableLayout {
  TableFormat format;
  std::size_t header_lines = 0;  ///< lines before the first scan
  std::size_t fields = 0;        ///< per line
  TableColumns columns;
  double range_unit_m = 1.0;
  double period_s = 0.0;  ///< median time between two scans; 0: no stamps
  /// Angles of the first and the last beam from a header line, rad.
  std::optional<double> first_angle, last_angle;
  bool full_turn = false;             ///< the first and the last beam see the same
  std::vector<std::string> warnings;  ///< what is a guess
};

/// Finds the layout from the first lines of a file. Empty if they are not a table of ranges.
std::optional<TableLayout> findTableLayout(const std::string& head);

}  // namespace kestrel
