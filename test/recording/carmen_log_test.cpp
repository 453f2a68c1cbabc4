// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/carmen_log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/iostreams/copy.hpp>
#include <boost/iostreams/filter/bzip2.hpp>
#include <boost/iostreams/filter/gzip.hpp>
#include <boost/iostreams/filtering_streambuf.hpp>
#include <cctype>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <vector>

#include "kestrel_slam/evaluation/evaluation.h"
#include "recording/read_all.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// A FLASER line in which every beam has the same `range`.
std::string frontLaser(std::size_t beams, double range, const std::string& poses,
                       const std::string& stamp) {
  std::ostringstream line;
  line << "FLASER " << beams;
  for (std::size_t i = 0; i < beams; ++i) line << ' ' << range;
  line << ' ' << poses << ' ' << stamp << " host 0.5\n";
  return line.str();
}

const std::string kOrigin = "0 0 0 0 0 0";
const std::string kHeader = "# CARMEN Logfile\n# message_name [message contents]\n";

template <typename Filter>
std::string packed(const std::string& text, Filter filter) {
  std::istringstream in(text);
  std::ostringstream out;
  boost::iostreams::filtering_streambuf<boost::iostreams::input> buffer;
  buffer.push(filter);
  buffer.push(in);
  boost::iostreams::copy(buffer, out);
  return out.str();
}

TEST(CarmenLine, ReadsEveryField) {
  const CarmenScan scan =
      parseCarmenScan("FLASER 3 1.5 80 0.25 1 2 0.5 3 4 -0.5 976052857.337530 host 0.1", 80.0);
  EXPECT_EQ(scan.scan.stamp, 976052857.337530);
  EXPECT_EQ(scan.scan.ranges,
            (std::vector<float>{1.5F, std::numeric_limits<float>::infinity(), 0.25F}));
  EXPECT_EQ(scan.scan.range_max, 80.0);
  EXPECT_EQ(scan.odom_T_laser, Pose2(1.0, 2.0, 0.5));
  EXPECT_EQ(scan.odom_T_base, Pose2(3.0, 4.0, -0.5));
  EXPECT_FALSE(scan.known_fan);
}

TEST(CarmenLine, KnowsTheFansOfTheSick) {
  const auto fan = [](std::size_t beams) {
    return parseCarmenScan(frontLaser(beams, 1.0, kOrigin, "1"), 80.0).scan;
  };
  const float start = static_cast<float>(-kPi / 2.0);
  for (const std::size_t beams : {180U, 181U, 360U, 361U}) EXPECT_EQ(fan(beams).angle_min, start);
  EXPECT_NEAR(fan(180).angle_min + 179.0 * fan(180).angle_increment, degToRad(89.0), 1e-6);
  EXPECT_NEAR(fan(360).angle_min + 359.0 * fan(360).angle_increment, degToRad(89.5), 1e-6);
  EXPECT_NEAR(fan(361).angle_min + 360.0 * fan(361).angle_increment, degToRad(90.0), 1e-6);
}

TEST(CarmenLine, AnglesAreExactInALaserScanMessage) {
  const LaserScan scan = parseCarmenScan(frontLaser(180, 1.0, kOrigin, "1"), 80.99).scan;
  for (const double value : {scan.angle_min, scan.angle_increment, scan.range_max}) {
    const volatile float message_field = static_cast<float>(value);
    EXPECT_EQ(message_field, value);
  }
}

TEST(CarmenLine, ReadsRobotLaser) {
  const CarmenScan scan = parseCarmenScan(
      "ROBOTLASER1 0 -1.5 3.0 0.5 30 0.01 0 2 1.25 30.5 1 77 1 2 0.5 3 4 -0.5 0 0 1 1 0 12.5 h 0",
      80.0);
  EXPECT_EQ(scan.scan.angle_min, -1.5);
  EXPECT_EQ(scan.scan.angle_increment, 0.5);
  EXPECT_EQ(scan.scan.range_max, 30.0);
  EXPECT_EQ(scan.scan.ranges, (std::vector<float>{1.25F, std::numeric_limits<float>::infinity()}));
  EXPECT_EQ(scan.odom_T_base, Pose2(3.0, 4.0, -0.5));
  EXPECT_EQ(scan.scan.stamp, 12.5);
}

TEST(CarmenLine, RejectsBrokenLines) {
  const auto problem = [](const std::string& line) {
    try {
      parseCarmenScan(line, 80.0);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_CONTAINS(problem("FLASER"), "ends before the number of beams");
  EXPECT_CONTAINS(problem("FLASER 2 1.0"), "ends before the ranges");
  EXPECT_CONTAINS(problem("FLASER 1 1.0 0 0 0 0 0 0 5.0"), "ends before the host name");
  EXPECT_CONTAINS(problem("FLASER 3 1.0 1.0 0 0 0 0 0 0 5.0 host 0"), "is not a number");
  EXPECT_CONTAINS(problem("FLASER 1 1.0 1.0 0 0 0 0 0 0 5.0 host 0"), "");
  EXPECT_NE(problem("FLASER 1 1.0 1.0 0 0 0 0 0 0 5.0 host 0"), "accepted");
  EXPECT_CONTAINS(problem("FLASER 1 abc 0 0 0 0 0 0 5.0 host 0"), "ranges is not a number");
  EXPECT_CONTAINS(problem("FLASER 1 1.0x 0 0 0 0 0 0 5.0 host 0"), "finite");
  EXPECT_CONTAINS(problem("FLASER 1 nan 0 0 0 0 0 0 5.0 host 0"), "finite");
  EXPECT_CONTAINS(problem("FLASER 1 1.0 0 0 inf 0 0 0 5.0 host 0"), "laser pose is not a finite");
  EXPECT_CONTAINS(problem("FLASER -1 0 0 0 0 0 0 5.0 host 0"), "valid count");
  EXPECT_CONTAINS(problem("FLASER 1e99 0 0 0 0 0 0 5.0 host 0"), "valid count");
  EXPECT_CONTAINS(problem("FLASER 1.5 1 0 0 0 0 0 0 5.0 host 0"), "valid count");
}

TEST(CarmenLog, ReadsPlainBzip2AndGzip) {
  const TemporaryFolder folder;
  const std::string text = kHeader + frontLaser(180, 2.0, "1 2 0.5 1 2 0.5", "10.25") +
                           "ODOM 1 2 0.5 0 0 0 10.3 host 0.6\n" +
                           frontLaser(180, 3.0, "1 3 0.5 1 3 0.5", "10.5");
  for (const std::string& path :
       {folder.write("a", text),
        folder.write("b", packed(text, boost::iostreams::bzip2_compressor())),
        folder.write("c", packed(text, boost::iostreams::gzip_compressor()))}) {
    const auto log = openRecording(path);
    EXPECT_EQ(log->scanCount(), 2U);
    EXPECT_TRUE(log->hasOdometry());
    const std::vector<RecordedScan> scans = readAll(*log);
    ASSERT_EQ(scans.size(), 2U) << path;
    EXPECT_EQ(scans[0].scan.stamp, 10.25);
    EXPECT_EQ(scans[0].time, 10.25);
    EXPECT_EQ(scans[0].odom_T_base, Pose2(1.0, 2.0, 0.5));
    EXPECT_TRUE(scans[0].base_T_laser.isApprox(Eigen::Isometry3d::Identity()));
    EXPECT_EQ(scans[1].scan.ranges, std::vector<float>(180, 3.0F));
    EXPECT_TRUE(log->warnings().empty());
  }
}

TEST(CarmenLog, MountingComesFromTheParameterOrThePoses) {
  const TemporaryFolder folder;
  const std::string behind = "0 -0.04 1.5707963267948966 0 0 1.5707963267948966";
  const auto mountingOf = [&](const std::string& text) {
    CarmenLog log(folder.write("log", text));
    return readAll(log).at(0).base_T_laser;
  };
  const Eigen::Isometry3d derived = mountingOf(frontLaser(1, 1.0, behind, "1"));
  EXPECT_TRUE(derived.translation().isApprox(Eigen::Vector3d(-0.04, 0.0, 0.0), 1e-6));
  const Eigen::Isometry3d parameter =
      mountingOf("PARAM robot_frontlaser_offset 0.3 host 0\n" + frontLaser(1, 1.0, behind, "1"));
  EXPECT_EQ(parameter.translation(), Eigen::Vector3d(0.3, 0.0, 0.0));
}

TEST(CarmenLog, CorrectedPosesAreNotUsedAsMounting) {
  const TemporaryFolder folder;
  CarmenLog log(folder.write(
      "log", frontLaser(180, 1.0, "5 5 1 0 0 0", "1") + frontLaser(180, 1.0, "6 5 1 2 0 0", "2")));
  EXPECT_TRUE(readAll(log).at(0).base_T_laser.isApprox(Eigen::Isometry3d::Identity()));
  ASSERT_EQ(log.warnings().size(), 1U);
  EXPECT_CONTAINS(log.warnings()[0], "robot_frontlaser_offset");
}

TEST(CarmenLog, NoReturnLimitComesFromTheParameter) {
  const TemporaryFolder folder;
  CarmenLog log(folder.write("log", "PARAM robot_front_laser_max 50.5 host 0\n" +
                                        frontLaser(180, 50.5, kOrigin, "1") +
                                        frontLaser(180, 50.25, kOrigin, "2")));
  const std::vector<RecordedScan> scans = readAll(log);
  EXPECT_EQ(scans.at(0).scan.ranges[0], std::numeric_limits<float>::infinity());
  EXPECT_EQ(scans.at(1).scan.ranges[0], 50.25F);
  EXPECT_EQ(scans.at(0).scan.range_max, 50.5);
  EXPECT_FALSE(log.hasOdometry());
  EXPECT_FALSE(scans.at(0).odom_T_base);
}

TEST(CarmenLog, BrokenLinesAreSkippedCountedAndReported) {
  const TemporaryFolder folder;
  const std::string good = frontLaser(180, 1.0, kOrigin, "1");
  CarmenLog log(folder.write("log", kHeader + good + "FLASER 180 1.0 nan\n" + good +
                                        "FLASER 2 1 1 0 0\n" + good.substr(0, 300)));
  const std::vector<RecordedScan> scans = readAll(log);
  EXPECT_EQ(scans.size(), 2U);
  EXPECT_EQ(log.scanCount(), 5U);
  EXPECT_EQ(log.skipped(), (std::map<std::string, std::size_t>{{"broken line", 3}}));
  ASSERT_EQ(log.warnings().size(), 1U);
  EXPECT_CONTAINS(log.warnings()[0], "line 4: broken FLASER line");
}

TEST(CarmenLog, WarnsOnceAboutAnUnknownFan) {
  const TemporaryFolder folder;
  const std::string line = frontLaser(7, 1.0, kOrigin, "1");
  CarmenLog log(folder.write("log", line + line));
  EXPECT_EQ(readAll(log).size(), 2U);
  ASSERT_EQ(log.warnings().size(), 1U);
  EXPECT_CONTAINS(log.warnings()[0], "line 1: FLASER with 7 beams");
}

TEST(CarmenLog, CutOffArchiveKeepsItsBeginning) {
  const TemporaryFolder folder;
  std::string text;
  for (int i = 0; i < 200; ++i) {
    text += frontLaser(180, 1.0 + 0.01 * i, kOrigin, std::to_string(100.0 + i));
  }
  const std::string whole = packed(text, boost::iostreams::gzip_compressor());
  CarmenLog log(folder.write("log.gz", whole.substr(0, whole.size() / 2)));
  const std::size_t found = readAll(log).size();
  EXPECT_GT(found, 20U);
  EXPECT_LT(found, 180U);
  ASSERT_EQ(log.warnings().size(), 1U);
  EXPECT_CONTAINS(log.warnings()[0], "damaged or cut off");
}

TEST(OpenRecording, ErrorsDescribeTheProblem) {
  const TemporaryFolder folder;
  const auto problem = [&](const std::string& path) {
    return messageOf([&] { openRecording(path); });
  };
  EXPECT_CONTAINS(problem(folder.file("none.clf")), "none.clf: the file does not exist");
  EXPECT_CONTAINS(problem(folder.file("")), "is a folder");
  EXPECT_CONTAINS(problem(folder.write("a", "")), "a: the file is empty (0 bytes)");
  EXPECT_CONTAINS(problem(folder.write("b", "Dear all,\nno laser here\n")),
                  "unknown format; use a rosbag");
  EXPECT_CONTAINS(problem(folder.write("c", std::string(5000, '\0'))), "unknown format");
  EXPECT_CONTAINS(problem(folder.write("d", "BZh91AY&SYgarbage")), "unknown format");
  EXPECT_CONTAINS(problem(folder.write("e", "ODOM 0 0 0 0 0 0 1 h 1\n")), "has no laser");
}

/// Checks that both stamps of every relation are stamps of scans.
void expectEveryRelationEndIsAScan(const std::string& name, std::size_t scans,
                                   std::size_t relations) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const auto log = openRecording(data + "/freiburg/" + name + ".clf.bz2");
  EXPECT_EQ(log->scanCount(), scans);
  std::set<double> stamps;
  RecordedScan scan;
  for (double last = -1.0; log->next(scan); last = scan.time) {
    EXPECT_GT(scan.time, last);
    stamps.insert(scan.scan.stamp);
  }
  EXPECT_EQ(stamps.size(), scans);
  EXPECT_TRUE(log->warnings().empty());
  const std::vector<Relation> read = readRelations(data + "/freiburg/" + name + ".relations");
  EXPECT_EQ(read.size(), relations);
  for (const Relation& relation : read) {
    for (const double end : {relation.stamp1, relation.stamp2}) {
      const auto nearest = stamps.lower_bound(end - 1e-6);
      EXPECT_TRUE(nearest != stamps.end() && *nearest <= end + 1e-6) << end;
    }
  }
}

TEST(RealLogs, RelationsOfIntelMatchScans) { expectEveryRelationEndIsAScan("intel", 13631, 2984); }

TEST(RealLogs, RelationsOfFr079MatchScans) { expectEveryRelationEndIsAScan("fr079", 4934, 1685); }

TEST(RealLogs, MountingAndOdometryOfFr079) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const auto log = openRecording(data + "/freiburg/fr079.clf.bz2");
  RecordedScan scan;
  ASSERT_TRUE(log->next(scan));
  EXPECT_EQ(scan.base_T_laser.translation(), Eigen::Vector3d(-0.04, 0.0, 0.0));
  EXPECT_EQ(scan.odom_T_base, Pose2(-3.034287, 8.291214, -3.120965));
  EXPECT_EQ(scan.scan.stamp, 1211.520329);
  EXPECT_EQ(scan.scan.ranges.size(), 360U);
  EXPECT_EQ(scan.scan.ranges[0], 1.67F);
}

// The odometry has this length in the order of the file; sorted by stamp it would be 661 m.
TEST(RealLogs, IntelIsReadInTheOrderOfTheFile) {
  const std::string data = dataFolder();
  SKIP_WITHOUT_DATA(data);
  const auto log = openRecording(data + "/freiburg/intel.clf.bz2");
  Trajectory odometry;
  RecordedScan scan;
  while (log->next(scan)) odometry.push_back({scan.scan.stamp, scan.odom_T_base.value()});
  EXPECT_NEAR(pathLength(odometry), 508.4, 0.1);
}

}  // namespace
}  // namespace kestrel
