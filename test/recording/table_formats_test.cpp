// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/recording/recording.h"
#include "recording/read_all.h"
#include "room_log.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr int kBeams = 360;
constexpr int kScans = 60;
constexpr double kPeriod = 0.1;  // s

/// Range of a beam in the room, m; the beams start at -180 degrees.
double rangeOf(int scan, int beam) {
  return RoomFlight::range(RoomFlight::x(scan), degToRad(beam - 180.0));
}

std::string format(const char* pattern, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

/// How a table is written.
struct Style {
  std::string separator = ",";
  bool decimal_comma = false, trailing_separator = false;
  double factor = 1.0;           // of the ranges
  const char* pattern = "%.3f";  // of the ranges
  std::string header;
  std::function<std::string(int)> prefix = [](int) { return std::string(); };
};

std::string tableOf(const Style& style, int scans = kScans) {
  std::string text;
  for (int i = 0; i < scans; ++i) {
    std::string line = style.prefix(i);
    for (int b = 0; b < kBeams; ++b) {
      line += (b == 0 ? "" : style.separator) + format(style.pattern, style.factor * rangeOf(i, b));
    }
    if (style.decimal_comma) std::replace(line.begin(), line.end(), '.', ',');
    text += line + (style.trailing_separator ? style.separator : "") + "\n";
  }
  return style.header + text;
}

class TableFormats : public testing::Test {
 protected:
  std::unique_ptr<Recording> open(const std::string& text, double fov_deg = 0.0) {
    RecordingOptions options;
    options.rate_hz = 1.0 / kPeriod;
    options.fov_deg = fov_deg;
    return openRecording(folder_.write("a.csv", text), options);
  }

  void expectTheRoom(const std::string& text, double start = 0.0) {
    const auto recording = open(text);
    EXPECT_EQ(recording->scanCount(), static_cast<std::size_t>(kScans));
    const std::vector<RecordedScan> scans = readAll(*recording);
    ASSERT_EQ(scans.size(), static_cast<std::size_t>(kScans)) << text.substr(0, 200);
    EXPECT_TRUE(recording->skipped().empty());
    for (int i = 0; i < kScans; i += 7) {
      const RecordedScan& scan = scans[static_cast<std::size_t>(i)];
      EXPECT_NEAR(scan.time, start + kPeriod * i, 1e-6);
      EXPECT_NEAR(scan.scan.stamp, start + kPeriod * i, 1e-6);
      EXPECT_NEAR(scan.scan.angle_min, -kPi, 1e-6);
      EXPECT_NEAR(scan.scan.angle_increment, degToRad(1.0), 1e-6);
      ASSERT_EQ(scan.scan.ranges.size(), static_cast<std::size_t>(kBeams));
      for (int b = 0; b < kBeams; ++b) {
        ASSERT_NEAR(scan.scan.ranges[static_cast<std::size_t>(b)], rangeOf(i, b), 1.1e-3);
      }
    }
    warnings_ = recording->warnings();
    description_ = recording->description();
  }

  bool warnedOf(const std::string& part) const {
    return std::any_of(warnings_.begin(), warnings_.end(), [&](const std::string& warning) {
      return warning.find(part) != std::string::npos;
    });
  }

  TemporaryFolder folder_;
  std::vector<std::string> warnings_;
  std::string description_;
};

TEST_F(TableFormats, AFullTurnIsSeenInTheRanges) {
  expectTheRoom(tableOf({}));
  ASSERT_EQ(warnings_.size(), 1U);
  EXPECT_CONTAINS(warnings_[0], "360 degrees are assumed");
  EXPECT_CONTAINS(warnings_[0], "--fov");
}

TEST_F(TableFormats, FieldOfViewFromTheOptions) {
  const auto recording = open(tableOf({}), 180.0);
  const LaserScan scan = readAll(*recording).at(0).scan;
  EXPECT_NEAR(scan.angle_min, -kPi / 2.0, 1e-9);
  EXPECT_NEAR(scan.angle_increment, kPi / 359.0, 1e-9);
  EXPECT_TRUE(recording->warnings().empty());
}

TEST_F(TableFormats, HeaderLines) {
  Style style;
  style.header = "# ranges of 360 beams, m\n\n# made by me\n";
  expectTheRoom(tableOf(style));
}

TEST_F(TableFormats, NamesOfColumns) {
  Style style;
  style.header = "beam0";
  for (int b = 1; b < kBeams; ++b) style.header += ",beam" + std::to_string(b);
  style.header += "\n";
  expectTheRoom(tableOf(style));
}

TEST_F(TableFormats, AHeaderOfAngles) {
  for (const bool degrees : {true, false}) {
    Style style;
    for (int b = 0; b < kBeams; ++b) {
      style.header +=
          (b == 0 ? "" : ",") + format("%.6f", degrees ? b - 180.0 : degToRad(b - 180.0));
    }
    style.header += "\n";
    expectTheRoom(tableOf(style));
    EXPECT_TRUE(warnings_.empty()) << warnings_.front();
  }
}

TEST_F(TableFormats, Millimeters) {
  Style style;
  style.factor = 1000.0;
  style.pattern = "%.0f";
  expectTheRoom(tableOf(style));
  EXPECT_TRUE(warnedOf("read as millimeters"));
  EXPECT_CONTAINS(description_, "in millimeters");
}

TEST_F(TableFormats, SeparatorsAndDecimalCommas) {
  for (const char* separator : {",", ";", "; ", "\t", " ", ", "}) {
    for (const bool decimal_comma : {false, true}) {
      if (decimal_comma && separator[0] == ',') continue;
      Style style;
      style.separator = separator;
      style.decimal_comma = decimal_comma;
      expectTheRoom(tableOf(style));
      style.trailing_separator = true;
      expectTheRoom(tableOf(style));
    }
  }
}

TEST_F(TableFormats, ColumnsOfStampsAndRowNumbers) {
  struct Kind {
    double start, unit;
    const char* pattern;
  };
  for (const auto& [start, unit, pattern] : {Kind{0.0, 1.0, "%.6f"},
                                             {1700000000.0, 1.0, "%.3f"},
                                             {1700000000.0, 1e-3, "%.0f"},
                                             {1700000000.0, 1e-6, "%.0f"},
                                             {50.0, 1e-9, "%.0f"}}) {
    for (const std::string separator : {",", " "}) {
      Style style;
      style.separator = separator;
      style.prefix = [&, start = start, unit = unit, pattern = pattern](int i) {
        return format(pattern, (start + kPeriod * i) / unit) + separator;
      };
      expectTheRoom(tableOf(style), start);
      EXPECT_CONTAINS(description_, "stamps in column 1, ranges from column 2");
      const auto stamps = style.prefix;
      style.prefix = [&](int i) { return std::to_string(i) + separator + stamps(i); };
      expectTheRoom(tableOf(style), start);
      EXPECT_CONTAINS(description_, "stamps in column 2, ranges from column 3");
      style.prefix = [&](int i) { return std::to_string(i) + separator; };
      expectTheRoom(tableOf(style));
      EXPECT_CONTAINS(description_, "10 Hz, ranges from column 2");
    }
  }
}

/// All ranges on one side rise.
TEST_F(TableFormats, RisingRangesAreNoStamps) {
  std::string text;
  for (int i = 0; i < 20; ++i) {
    for (int b = 0; b < 40; ++b) {
      text += (b == 0 ? "" : ",") + format("%.4f", 2.0 + 0.05 * i + 0.01 * b);
    }
    text += "\n";
  }
  EXPECT_EQ(readAll(*open(text)).at(0).scan.ranges.size(), 40U);
}

std::string namesOf(const std::string& fields, const std::string& ranges) {
  std::string names = fields;
  for (int b = 0; b < kBeams; ++b) names += "," + ranges + std::to_string(b);
  return names;
}

TEST_F(TableFormats, RostopicEcho) {
  Style style;
  style.header = namesOf(
                     "%time,field.header.seq,field.header.stamp,field.header.frame_id,"
                     "field.angle_min,field.angle_max,field.angle_increment,"
                     "field.time_increment,field.scan_time,field.range_min,field.range_max",
                     "field.ranges") +
                 ",field.intensities0\n";
  style.prefix = [](int i) {
    const std::string stamp = format("%.0f", 50e9 + 1e8 * i);
    return stamp + "," + std::to_string(i) + "," + stamp +
           ",laser,-3.14159265,3.12413936,0.01745329252,0.00027,0.1,0.15,12.0,";
  };
  std::string text = tableOf(style);
  std::size_t at = text.find('\n') + 1;  // an intensity at the end of each line
  while ((at = text.find('\n', at)) != std::string::npos) {
    text.insert(at, ",47");
    at += 4;
  }
  expectTheRoom(text, 50.0);
  EXPECT_TRUE(warnings_.empty()) << warnings_.front();
  const LaserScan scan = readAll(*open(text)).at(1).scan;
  EXPECT_EQ(scan.time_increment, 0.00027);
  EXPECT_EQ(scan.range_min, 0.15);
  EXPECT_EQ(scan.range_max, 12.0);
}

TEST_F(TableFormats, RostopicEchoOfTheRangesAlone) {
  Style style;
  style.header = namesOf("%time", "field") + "\n";
  style.prefix = [](int i) { return format("%.0f,", 50e9 + 1e8 * i); };
  expectTheRoom(tableOf(style), 50.0);
}

TEST_F(TableFormats, RostopicEchoOfFourBeams) {
  const auto recording = open(
      "%time,field.header.stamp,field.angle_min,field.angle_increment,field.range_max,"
      "field.ranges0,field.ranges1,field.ranges2,field.ranges3\n"
      "5000000000,5000000000,0.0,1.57,4.0,1.0,2.0,inf,3.0\n");
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_EQ(scans[0].time, 5.0);
  EXPECT_EQ(scans[0].scan.ranges[3], 3.0F);
}

TEST_F(TableFormats, Ros2TopicEcho) {
  Style style;
  style.prefix = [](int i) {
    return std::to_string(50 + i / 10) + "," + std::to_string(i % 10 * 100000000) +
           ",laser,-3.14159265,3.12413936,0.01745329252,0.00027,0.1,0.15,12.0,";
  };
  expectTheRoom(tableOf(style), 50.0);
  EXPECT_TRUE(warnings_.empty()) << warnings_.front();
}

/// Poses, IMU data and the like have fewer columns, and they must not be taken for ranges.
TEST_F(TableFormats, OtherTablesAreRefused) {
  std::string imu = "time,wx,wy,wz,ax,ay,az,qx,qy,qz,qw\n", tum;
  for (int i = 0; i < 40; ++i) {
    imu += std::to_string(0.01 * i) + ",0,0,0,0,0,9.8,0,0,0,1\n";
    tum += std::to_string(0.01 * i) + " 0 0 0 0 0 0 1 5 6 7 8\n";
  }
  for (const std::string& text : {imu, tum}) {
    EXPECT_CONTAINS(messageOf([&] { open(text); }), "unknown format");
  }
}

TEST_F(TableFormats, TheCasesOfTheTables) {
  const std::string cases = dataFolder() + "/../cases/21_tables";
  if (!std::filesystem::exists(cases)) GTEST_SKIP() << "no folder " << cases;
  for (const char* name :
       {"drow.csv", "header.csv", "mm.csv", "rostopic.csv", "semicolon.csv", "stamped.txt"}) {
    RecordingOptions options;
    options.rate_hz = 10.0;
    const auto recording = openRecording(cases + "/" + name, options);
    const std::vector<RecordedScan> scans = readAll(*recording);
    ASSERT_EQ(scans.size(), 60U) << name;
    EXPECT_NEAR(scans[59].time - scans[0].time, 5.9, 1e-6) << name;
    EXPECT_NEAR(scans[0].scan.angle_min, -kPi, 1e-6) << name;
    EXPECT_NEAR(scans[0].scan.angle_increment, degToRad(1.0), 1e-6) << name;
    ASSERT_EQ(scans[0].scan.ranges.size(), 360U) << name;
    EXPECT_NEAR(scans[0].scan.ranges[0], 4.003, 1e-5) << name;
  }
}

}  // namespace
}  // namespace kestrel
