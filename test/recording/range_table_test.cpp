// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/range_table.h"

#include <gtest/gtest.h>

#include <boost/iostreams/device/file.hpp>
#include <boost/iostreams/filter/lzma.hpp>
#include <boost/iostreams/filtering_stream.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "recording/read_all.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// A line of `count` ranges: value, value + 0.5, value, value + 0.5, ...
std::string lineOf(std::size_t count, double value) {
  std::string line = std::to_string(value);
  for (std::size_t i = 1; i < count; ++i)
    line += ',' + std::to_string(i % 2 == 0 ? value : value + 0.5);
  return line + '\n';
}

std::string packed(const TemporaryFolder& folder, const std::string& text) {
  namespace io = boost::iostreams;
  const std::string path = folder.file("a.csv.xz");
  io::filtering_ostream out;
  out.push(io::lzma_compressor());
  out.push(io::file_sink(path, std::ios::binary));
  out << text;
  return path;
}

TEST(RangeTable, NumberOfRangesDeterminesTheLaser) {
  const TemporaryFolder folder;
  const auto recording =
      openRecording(folder.write("a.csv", lineOf(1081, 1.25) + lineOf(1081, 2.0)));
  EXPECT_EQ(recording->scanCount(), 2U);
  EXPECT_EQ(recording->description(),
            "table of ranges, 2 scans of 1081 beams (UTM-30LX), 40 Hz, without odometry");
  EXPECT_FALSE(recording->hasOdometry());
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 2U);
  const LaserScan& scan = scans[0].scan;
  EXPECT_EQ(scan.stamp, 0.0);
  EXPECT_EQ(scans[1].scan.stamp, 0.025);
  EXPECT_EQ(scans[1].time, 0.025);
  EXPECT_NEAR(scan.angle_min, degToRad(-135.0), 1e-12);
  EXPECT_NEAR(scan.angle_increment, degToRad(0.25), 1e-12);
  EXPECT_NEAR(scan.time_increment, 0.025 / 1440.0, 1e-12);
  EXPECT_EQ(scan.range_max, 30.0);
  ASSERT_EQ(scan.ranges.size(), 1081U);
  EXPECT_EQ(scan.ranges[0], 1.25F);
  EXPECT_EQ(scan.ranges[1], 1.75F);
  EXPECT_EQ(scans[1].scan.ranges[1080], 2.0F);
  EXPECT_TRUE(recording->warnings().empty());
}

TEST(RangeTable, KnowsTheFansOfTheUrg) {
  const TemporaryFolder folder;
  for (const std::size_t beams : {681U, 682U}) {
    const auto recording = openRecording(folder.write("a.csv", lineOf(beams, 1.0)));
    const LaserScan scan = readAll(*recording).at(0).scan;
    const double increment = degToRad(0.3515625);
    EXPECT_NEAR(scan.angle_increment, increment, 1e-12);
    EXPECT_NEAR(scan.angle_min, -0.5 * static_cast<double>(beams - 1) * increment, 1e-12);
  }
}

TEST(RangeTable, UnknownFanGets270DegreesAndAWarning) {
  const TemporaryFolder folder;
  const auto recording = openRecording(folder.write("a.csv", lineOf(541, 1.0)));
  const LaserScan scan = readAll(*recording).at(0).scan;
  EXPECT_NEAR(scan.angle_min, degToRad(-135.0), 1e-12);
  EXPECT_NEAR(scan.angle_increment, degToRad(0.5), 1e-12);
  EXPECT_CONTAINS(recording->warnings().at(0),
                  "541 ranges per line does not give its field of view");
}

TEST(RangeTable, RateComesFromTheOptions) {
  const TemporaryFolder folder;
  const std::string path = folder.write("a.csv", lineOf(682, 1.0) + lineOf(682, 1.0));
  RecordingOptions options;
  options.rate_hz = 10.0;
  const std::vector<RecordedScan> scans = readAll(*openRecording(path, options));
  EXPECT_EQ(scans.at(1).time, 0.1);
  for (const double rate : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    options.rate_hz = rate;
    EXPECT_CONTAINS(messageOf([&] { openRecording(path, options); }), "needs a rate above 0 Hz");
  }
}

TEST(RangeTable, BrokenLinesAreSkippedCountedAndLeaveAGap) {
  const TemporaryFolder folder;
  std::string text = lineOf(682, 1.0) + lineOf(682, 2.0) + lineOf(682, 3.0) + "1.0,2.0,3.";
  text[text.find("2.000000", 9000)] = 'x';
  const auto recording = openRecording(folder.write("a.csv", text));
  EXPECT_EQ(recording->scanCount(), 4U);
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 2U);
  EXPECT_EQ(scans[1].scan.stamp, 0.05);
  EXPECT_EQ(recording->skipped(), (std::map<std::string, std::size_t>{{"broken line", 2}}));
  EXPECT_EQ(recording->warnings().at(0), "line 2: broken line skipped: a field is not a number");
}

TEST(RangeTable, KeepsNanAndInfAndReadsCarriageReturns) {
  const TemporaryFolder folder;
  const auto recording =
      openRecording(folder.write("a.csv", "1, nan,inf,-inf,5,6,7,8\r\n\r\n1,2,3,4,5,6,7,8\r\n"));
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 2U);
  const std::vector<float>& ranges = scans[0].scan.ranges;
  EXPECT_TRUE(std::isnan(ranges[1]));
  EXPECT_EQ(ranges[2], std::numeric_limits<float>::infinity());
  EXPECT_EQ(ranges[3], -std::numeric_limits<float>::infinity());
  EXPECT_EQ(ranges[7], 8.0F);
}

TEST(RangeTable, OtherTextIsNotATable) {
  const TemporaryFolder folder;
  for (const char* text :
       {"a,b,c,d,e,f,g,h,i\n", "1,2,3\n", "1 2 3 4 5 6 7 8 9\n", "1,2,3,4,5,6,,8\n", "\n"}) {
    EXPECT_FALSE(looksLikeRangeTable(folder.write("a.csv", text))) << text;
    EXPECT_CONTAINS(
        messageOf([&] { openRecording(folder.file("a.csv")); }),
        "a.csv: unknown format; use a rosbag, a CARMEN log, a BreezySLAM log or a table");
  }
}

TEST(RangeTable, XzIsDecompressedAndACutOffFileKeepsItsBeginning) {
  const TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 300; ++i) text += lineOf(1081, 1.0 + std::sin(i * i));
  const std::string path = packed(folder, text);
  EXPECT_EQ(readAll(*openRecording(path)).size(), 300U);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) * 2 / 3);
  const auto recording = openRecording(path);
  const std::size_t count = readAll(*recording).size();
  EXPECT_GT(count, 100U);
  EXPECT_LT(count, 300U);
  EXPECT_CONTAINS(recording->warnings().back(), "the data are damaged or cut off");
}

TEST(RealRangeTable, ReadsTheQuadrotorTakeoff) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const auto recording = openRecording(data + "/mav/quadrotor_takeoff_utm30lx.csv.xz");
  EXPECT_EQ(recording->scanCount(), 191U);
  const std::vector<RecordedScan> scans = readAll(*recording);
  ASSERT_EQ(scans.size(), 190U);
  EXPECT_EQ(recording->skipped().at("broken line"), 1U);
  EXPECT_EQ(recording->warnings().at(0),
            "line 191: broken line skipped: it has 542 ranges, not 1081");
  EXPECT_EQ(scans[0].scan.ranges[0], 0.001F);
  EXPECT_EQ(scans[189].scan.stamp, 4.725);
}

}  // namespace
}  // namespace kestrel
