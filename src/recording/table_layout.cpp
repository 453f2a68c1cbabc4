// SPDX-License-Identifier: BSD-3-Clause
#include "table_layout.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/recording/fan.h"

namespace kestrel {
namespace {

constexpr std::size_t kMinBeams = 8;     // a line with fewer numbers is not a scan
constexpr std::size_t kMinColumns = 24;  // of a table that is not just commas and numbers:
                                         // poses and IMU data have fewer
constexpr std::size_t kMaxHeaderLines = 50;
constexpr std::size_t kMaxRows = 500;  // to look at
constexpr std::size_t kMinRows = 8;    // fewer rows do not show which columns are stamps
constexpr double kMillimeter = 1e-3;
constexpr double kNanosecond = 1e-9;

using Row = std::vector<double>;

double medianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return values.empty() ? 0.0 : *middle;
}

bool parseRow(const std::vector<std::string_view>& fields, const TableFormat& format, Row& row) {
  row.resize(fields.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (!parseField(fields[i], format, row[i])) return false;
  }
  return true;
}

// --- tables with the fields of a LaserScan message

/// "field.ranges12" and "ranges_12" become "ranges12".
std::string plainName(std::string_view field) {
  std::string name;
  for (const char c : field) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.') {
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return name.rfind("field.", 0) == 0 ? name.substr(6) : name;
}

bool isRangeName(const std::string& name) {
  const std::size_t digits = name.find_last_not_of("0123456789") + 1;
  const std::string word = name.substr(0, digits);
  return digits < name.size() && (word == "ranges" || word == "range" || word == "field");
}

/// Columns by the names in a header line, as `rostopic echo -p` writes them.
std::optional<TableColumns> columnsByName(const std::vector<std::string_view>& fields) {
  TableColumns columns;
  const std::pair<const char*, std::optional<std::size_t>*> names[] = {
      {"anglemin", &columns.angle_min},           {"angleincrement", &columns.angle_increment},
      {"timeincrement", &columns.time_increment}, {"rangemin", &columns.range_min},
      {"rangemax", &columns.range_max},           {"header.stamp", &columns.stamp},
      {"header.stamp.secs", &columns.stamp},      {"header.stamp.nsecs", &columns.nanoseconds}};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string name = plainName(fields[i]);
    for (const auto& [known, column] : names) {
      if (name == known) *column = i;
    }
    if (!isRangeName(name)) continue;
    if (columns.beams++ == 0) columns.first_range = i;
  }
  if (columns.beams < (columns.angle_increment ? 1 : kMinBeams)) return std::nullopt;
  if (!columns.stamp && plainName(fields[0]) == "time") columns.stamp = 0;
  const bool is_rostopic = !fields[0].empty() && fields[0].front() == '%';
  columns.stamp_unit_s = is_rostopic ? kNanosecond : 1.0;
  return columns;
}

/// Columns of `ros2 topic echo --csv`, which has no header: sec, nanosec, frame_id, angle_min,
/// angle_max, angle_increment, time_increment, scan_time, range_min, range_max, ranges,
/// intensities.
std::optional<TableColumns> columnsOfRos2(const std::vector<std::string_view>& fields,
                                          const TableFormat& format) {
  constexpr std::size_t kFrame = 2, kAngleMin = 3, kRanges = 10;
  double unused = 0.0;
  if (fields.size() < kRanges + kMinBeams || parseField(fields[kFrame], format, unused)) {
    return std::nullopt;
  }
  Row numbers;
  if (!parseRow({fields.begin() + kAngleMin, fields.end()}, format, numbers)) return std::nullopt;
  const double beams = std::round((numbers[1] - numbers[0]) / numbers[2]) + 1.0;
  if (!(beams >= kMinBeams && beams <= static_cast<double>(fields.size() - kRanges))) {
    return std::nullopt;
  }
  TableColumns columns;
  columns.stamp = 0;
  columns.nanoseconds = 1;
  columns.angle_min = kAngleMin;
  columns.angle_increment = kAngleMin + 2;
  columns.time_increment = kAngleMin + 3;
  columns.range_min = kAngleMin + 5;
  columns.range_max = kAngleMin + 6;
  columns.first_range = kRanges;
  columns.beams = static_cast<std::size_t>(beams);
  return columns;
}

// --- tables of numbers

bool rises(const std::vector<Row>& rows, std::size_t column) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (!(rows[i][column] > rows[i - 1][column])) return false;
  }
  return rows.size() > 1;
}

bool isRowNumber(const std::vector<Row>& rows, std::size_t column) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i][column] - rows[i - 1][column] != 1.0) return false;
  }
  return rows.front()[column] == std::floor(rows.front()[column]);
}

/// Columns before the ranges: row numbers or stamps. They rise in every line, and no range does so
/// without its neighbors.
std::size_t leadingColumns(const std::vector<Row>& rows) {
  std::size_t count = 0;
  while (count < 3 && rises(rows, count)) ++count;
  if (count == 3) return 0;
  const bool explains_count = fanOf(rows.front().size() - count).known;
  return rows.size() >= kMinRows || explains_count ? count : 0;
}

double medianStep(const std::vector<Row>& rows, std::size_t column) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    steps.push_back(rows[i][column] - rows[i - 1][column]);
  }
  return medianOf(std::move(steps));
}

/// The unit of stamps. Lasers scan every 1 ms to 1 s.
double stampUnit(double step) {
  double unit = 1.0;
  for (; step * unit > 1.0 && unit > kNanosecond; unit *= 1e-3) {
  }
  return unit;
}

void findStamps(const std::vector<Row>& rows, TableColumns& columns) {
  for (std::size_t i = 0; i < columns.first_range; ++i) {
    if (!columns.stamp && !isRowNumber(rows, i)) columns.stamp = i;
  }
  if (columns.stamp) columns.stamp_unit_s = stampUnit(medianStep(rows, *columns.stamp));
}

/// A first line of angles, in degrees or radians: it rises or falls by the same step.
bool takeAngles(std::vector<Row>& rows, TableLayout& layout) {
  constexpr double kTolerance = 1e-2;  // of a step; the angles are rounded
  const Row& row = rows.front();
  if (rows.size() < 2 || row.size() != rows[1].size() || row.size() < kMinColumns) return false;
  const double step = (row.back() - row.front()) / static_cast<double>(row.size() - 1);
  for (std::size_t i = 1; i < row.size(); ++i) {
    if (!(std::abs(row[i] - row[i - 1] - step) <= kTolerance * std::abs(step))) return false;
  }
  if (step == 0.0) return false;
  const bool degrees = std::abs(row.back() - row.front()) > 2.0 * kPi + 1e-3;
  layout.first_angle = degrees ? degToRad(row.front()) : row.front();
  layout.last_angle = degrees ? degToRad(row.back()) : row.back();
  rows.erase(rows.begin());
  ++layout.header_lines;
  return true;
}

// --- values

/// Ranges of one row, without those that are no measurement.
std::vector<double> measured(const Row& row, const TableColumns& columns) {
  std::vector<double> ranges;
  for (std::size_t i = 0; i < columns.beams; ++i) {
    const double range = row[columns.first_range + i];
    if (std::isfinite(range) && range > 0.0) ranges.push_back(range);
  }
  return ranges;
}

/// Whole numbers that are too large for meters are millimeters.
void findRangeUnit(const std::vector<Row>& rows, TableLayout& layout) {
  std::vector<double> ranges;
  for (const Row& row : rows) {
    const std::vector<double> more = measured(row, layout.columns);
    ranges.insert(ranges.end(), more.begin(), more.end());
  }
  const bool whole = std::all_of(ranges.begin(), ranges.end(),
                                 [](double range) { return range == std::floor(range); });
  const double median = medianOf(std::move(ranges));
  if (!whole || median <= fanOf(layout.columns.beams).range_max) return;
  layout.range_unit_m = kMillimeter;
  std::ostringstream text;
  text << "the ranges are whole numbers with a median of " << median
       << ": they are read as millimeters";
  layout.warnings.push_back(text.str());
}

/// Compares the step from the last beam to the first with the steps between neighbors.
void findFullTurn(const std::vector<Row>& rows, TableLayout& layout) {
  std::vector<double> ends, steps;
  for (const Row& row : rows) {
    const std::vector<double> ranges = measured(row, layout.columns);
    if (ranges.size() < 2) continue;
    ends.push_back(std::abs(ranges.front() - ranges.back()));
    for (std::size_t i = 1; i < ranges.size(); ++i) {
      steps.push_back(std::abs(ranges[i] - ranges[i - 1]));
    }
  }
  if (ends.size() < kMinRows) return;
  layout.full_turn = medianOf(std::move(ends)) <= 2.0 * medianOf(std::move(steps));
}

class Finder {
 public:
  std::optional<TableLayout> find(const std::string& head) {
    std::istringstream lines(head);
    std::string line, next;
    bool more = static_cast<bool>(std::getline(lines, line));
    while (more) {
      more = static_cast<bool>(std::getline(lines, next));
      const bool whole = more || head.back() == '\n' || rows_.empty();
      if (whole && rows_.size() < kMaxRows && !take(line)) return std::nullopt;
      line.swap(next);
    }
    return finish();
  }

 private:
  /// False if this is not a table.
  bool take(const std::string& line) {
    if (rows_.empty()) return takeFirst(line);
    const std::vector<std::string_view> fields = fieldsOf(line, layout_.format);
    Row row;
    if (fields.size() == layout_.fields && parse(fields, row)) rows_.push_back(std::move(row));
    return true;
  }

  bool takeFirst(const std::string& line) {
    layout_.format = formatOf(line);
    const std::vector<std::string_view> fields = fieldsOf(line, layout_.format);
    if (!named_ && !line.empty() && line.find('\0') == line.npos) named_ = columnsByName(fields);
    const bool is_names = named_ && names_ == 0;
    if (is_names) names_ = fields.size();
    if (!named_) named_ = columnsOfRos2(fields, layout_.format);
    Row row;
    if (!is_names && fields.size() >= kMinBeams && parse(fields, row)) {
      layout_.fields = fields.size();
      rows_.push_back(std::move(row));
      return true;
    }
    return ++layout_.header_lines <= kMaxHeaderLines;
  }

  /// In tables with names only the ranges have to be numbers.
  bool parse(const std::vector<std::string_view>& fields, Row& row) const {
    if (!named_) return parseRow(fields, layout_.format, row);
    row.assign(fields.size(), 0.0);
    const std::size_t end = named_->first_range + named_->beams;
    if (fields.size() < end) return false;
    for (std::size_t i = named_->first_range; i < end; ++i) {
      if (!parseField(fields[i], layout_.format, row[i])) return false;
    }
    return true;
  }

  std::optional<TableLayout> finish() {
    if (rows_.empty() || rows_.front().size() < minimumColumns()) return std::nullopt;
    if (named_) {
      layout_.columns = *named_;
    } else {
      takeAngles(rows_, layout_);
      TableColumns& columns = layout_.columns;
      columns.first_range = layout_.first_angle ? 0 : leadingColumns(rows_);
      columns.beams = layout_.fields - columns.first_range;
      findStamps(rows_, columns);
      if (columns.stamp) {
        layout_.period_s = medianStep(rows_, *columns.stamp) * columns.stamp_unit_s;
      }
      if (columns.beams < kMinBeams) return std::nullopt;
    }
    findFullTurn(rows_, layout_);
    findRangeUnit(rows_, layout_);
    return std::move(layout_);
  }

  std::size_t minimumColumns() const {
    const bool plain = layout_.format.separator == ',' && layout_.header_lines == 0;
    return plain || named_ ? kMinBeams : kMinColumns;
  }

  TableLayout layout_;
  std::optional<TableColumns> named_;
  std::size_t names_ = 0;  ///< number of names in the header
  std::vector<Row> rows_;
};

}  // namespace

std::optional<TableLayout> findTableLayout(const std::string& head) { return Finder().find(head); }

}  // namespace kestrel
