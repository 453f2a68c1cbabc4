// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <boost/iostreams/copy.hpp>
#include <boost/iostreams/filter/gzip.hpp>
#include <boost/iostreams/filtering_streambuf.hpp>
#include <cctype>
#include <cmath>
#include <sstream>
#include <vector>

#include "kestrel_slam/recording/carmen_log.h"
#include "recording/read_all.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

std::string gzipped(const std::string& text) {
  std::istringstream in(text);
  std::ostringstream out;
  boost::iostreams::filtering_streambuf<boost::iostreams::input> buffer;
  buffer.push(boost::iostreams::gzip_compressor());
  buffer.push(in);
  boost::iostreams::copy(buffer, out);
  return out.str();
}

/// A drive along x with the laser 0.2 m before the center, in one of the two laser messages.
std::string driveLog(bool front) {
  std::ostringstream log;
  log << "# CARMEN Logfile\n" << std::fixed;
  for (int i = 0; i < 40; ++i) {
    const double x = 0.05 * i;
    log << "ODOM " << x << " 0.0 0.0 0.5 0.0 0.0 " << 1000.0 + 0.1 * i << " host " << 0.1 * i
        << "\n";
    log << (front ? "FLASER 180" : "ROBOTLASER1 0 -1.5 3.0 0.15 80.0 0.01 0 20");
    for (int b = 0; b < (front ? 180 : 20); ++b) log << ' ' << 3.0 + 0.01 * b - x;
    log << (front ? " " : " 0 ") << x + 0.2 << " 1.0 0.0 " << x << " 1.0 0.0 "
        << (front ? "" : "0.5 0.0 1.0 1.0 0 ") << 1000.05 + 0.1 * i << " host " << 0.05 + 0.1 * i
        << "\n";
  }
  return log.str();
}

bool isEqual(const RecordedScan& a, const RecordedScan& b) {
  return a.scan.ranges == b.scan.ranges && a.time == b.time && a.scan.stamp == b.scan.stamp &&
         a.scan.angle_min == b.scan.angle_min && a.odom_T_base == b.odom_T_base &&
         a.scan.angle_increment == b.scan.angle_increment && a.scan.range_max == b.scan.range_max &&
         a.base_T_laser.isApprox(b.base_T_laser);
}

/// Silent changes of a log with one flipped bit. A digit of a range or stamp that became another
/// digit cannot be noticed.
TEST(DamagedLog, FlippedBitsAreSaidExceptOfDigitsInRangesAndStamps) {
  const TemporaryFolder folder;
  for (const bool front : {true, false}) {
    const std::string good = driveLog(front);
    const std::vector<RecordedScan> expected = readAll(*openRecording(folder.write("a.clf", good)));
    ASSERT_EQ(expected.size(), 40U);
    std::size_t changed = 0;
    for (std::size_t bit = 0; bit < 8 * good.size(); bit += front ? 1327 : 271) {
      std::string text = good;
      text[bit / 8] = static_cast<char>(text[bit / 8] ^ (1 << (bit % 8)));
      CarmenLog log(folder.write("a.clf", text));
      const std::vector<RecordedScan> scans = readAll(log);
      if (!log.warnings().empty()) continue;
      ASSERT_EQ(scans.size(), expected.size()) << text.substr(bit / 8 - 20, 40);
      for (std::size_t i = 0; i < scans.size(); ++i) {
        if (isEqual(scans[i], expected[i])) continue;
        ++changed;
        EXPECT_NE(std::isdigit(text[bit / 8]), 0) << text.substr(bit / 8 - 20, 40);
        const Pose2 moved = scans[i].odom_T_base->inverse() * *expected[i].odom_T_base;
        EXPECT_LE(moved.distance(), 0.002) << text.substr(bit / 8 - 20, 40);  // the tolerance
        EXPECT_EQ(scans[i].scan.angle_min, expected[i].scan.angle_min);
        EXPECT_EQ(scans[i].scan.angle_increment, expected[i].scan.angle_increment);
        EXPECT_TRUE(scans[i].base_T_laser.isApprox(expected[i].base_T_laser));
        EXPECT_NEAR(scans[i].scan.stamp, expected[i].scan.stamp, 0.91);
      }
    }
    EXPECT_GT(changed, 0U);
  }
}

TEST(DamagedLog, UnknownNamesAndContradictionsAreNamed) {
  const TemporaryFolder folder;
  std::string text = driveLog(true);
  text[text.find("FLASER", 3000)] = 'G';
  CarmenLog renamed(folder.write("a.clf", text));
  EXPECT_EQ(readAll(renamed).size(), 39U);
  EXPECT_CONTAINS(renamed.warnings().at(0),
                  "1 lines with damaged message names or ends skipped, among them 'GLASER'");
  text = driveLog(true);
  text.replace(text.find("1.200000 1.0 0.0"), 4, "9.20");
  CarmenLog moved(folder.write("a.clf", text));
  const std::vector<RecordedScan> scans = readAll(moved);
  EXPECT_CONTAINS(moved.warnings().at(0),
                  "in 1 of 40 lines the poses of laser and robot contradict");
  EXPECT_EQ(std::count_if(scans.begin(), scans.end(),
                          [](const RecordedScan& scan) { return !scan.odom_T_base; }),
            1);
  EXPECT_NEAR(scans[0].base_T_laser.translation().x(), 0.2, 1e-9);
}

TEST(DamagedLog, RefusesAPipeAndEndsAtAnEndlessLine) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo(folder.file("pipe").c_str(), 0600), 0);
  EXPECT_CONTAINS(messageOf([&] { openRecording(folder.file("pipe")); }), "is a pipe or a device");
  const std::string text = driveLog(true) + "FLASER 180 " + std::string(40U << 20U, '1');
  const auto log = openRecording(folder.write("a.clf.gz", gzipped(text)));
  EXPECT_EQ(readAll(*log).size(), 40U);
  EXPECT_CONTAINS(log->warnings().back(), "damaged or cut off after line");
}

}  // namespace
}  // namespace kestrel
