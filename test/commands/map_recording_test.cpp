// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <sstream>

#include "kestrel_slam/evaluation/scan_file.h"
#include "kestrel_slam/map/map_io.h"
#include "kestrel_slam/parameters/parameters_yaml.h"
#include "kestrel_slam/recording/trajectory.h"
#include "kestrel_slam/session/version.h"
#include "room_log_test.h"
#include "run_command.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 7> kOutputs = {"map.pgm",       "map.yaml",  "trajectory.tum",
                                                 "thumbnail.png", "scans.csv", "stats.json",
                                                 "report.html"};

const std::string kMap = KESTREL_TOOL_DIR "/map_recording ";

constexpr int kScans = 41;

class MapRecordingTest : public RoomLogTest {
 protected:
  MapRecordingTest() : RoomLogTest(kScans) {}

  Outcome map(const std::string& arguments) { return runCommand(kMap + log_ + " " + arguments); }
};

TEST_F(MapRecordingTest, WritesAllFilesAndPrintsTheirPaths) {
  const Outcome outcome = map(outputs("out"));
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_CONTAINS(outcome.output, "scans       41 processed, 0 dropped, 0 lost\n");
  EXPECT_CONTAINS(outcome.output, "map         " + folder_.file("out/map.yaml") + "\n");
  EXPECT_CONTAINS(outcome.output, "trajectory  " + folder_.file("out/trajectory.tum") + "\n");
  EXPECT_CONTAINS(outcome.output, "report      " + folder_.file("out/report.html") + "\n");
  EXPECT_CONTAINS(outcome.output, "x real time");
  for (const char* name : kOutputs) EXPECT_TRUE(fs::exists(folder_.file("out/") + name)) << name;

  const Trajectory trajectory = readTum(folder_.file("out/trajectory.tum"));
  ASSERT_EQ(trajectory.size(), 41U);
  EXPECT_EQ(trajectory[3].stamp, RoomFlight::stamp(3));
  EXPECT_NEAR(trajectory.back().pose.x, 2.0, 0.03);
  const MapSnapshot written = readMap(folder_.file("out/map.yaml"));
  EXPECT_NEAR(written.width * written.resolution_m, 5.0, 1.5);  // the walls in front of the vehicle
}

TEST_F(MapRecordingTest, AddsErrorsToTheOdometryAndWritesIt) {
  ASSERT_EQ(map("--odometry use --odometry-error short:0.5" + outputs("out")).code, 0);
  const std::vector<ScanRow> scans = readScans(folder_.file("out/scans.csv"));
  ASSERT_EQ(scans.size(), 41U);
  ASSERT_TRUE(scans.front().odom_T_base && scans.back().odom_T_base);
  EXPECT_EQ(scans.front().reason, "fits");
  EXPECT_NEAR(scans.front().odom_T_base->between(*scans.back().odom_T_base).x, 1.0, 1e-3);
  EXPECT_NEAR(scans.back().pose.x, 2.0, 0.1) << "the scans correct it";
  const Outcome wrong = map("--odometry use --odometry-error long:1" + outputs("out"));
  EXPECT_EQ(wrong.code, 2);
  EXPECT_CONTAINS(wrong.output, "'long:1' is no odometry error; use short:SHARE");
}

TEST_F(MapRecordingTest, MapsWithTheKnownPosesOfAnotherTrajectory) {
  ASSERT_EQ(map(outputs("out")).code, 0);
  Trajectory poses = readTum(folder_.file("out/trajectory.tum"));
  const Pose2 other_T_map(10.0, 5.0, 1.0);
  for (StampedPose& pose : poses) pose.pose = other_T_map * pose.pose;
  writeTum(folder_.file("poses.tum"), poses);
  const std::string known = "--set map_with_known_poses=true ";
  const Outcome done = map("--odometry " + folder_.file("poses.tum") + " " + known + outputs("b"));
  ASSERT_EQ(done.code, 0) << done.output;
  const Trajectory result = readTum(folder_.file("b/trajectory.tum"));
  ASSERT_EQ(result.size(), poses.size());
  for (std::size_t i = 0; i < result.size(); ++i)
    EXPECT_LT((poses[i].pose.inverse() * result[i].pose).distance(), 1e-6);
  EXPECT_EQ(readScans(folder_.file("b/scans.csv")).back().reason, "fits");
  const Outcome without = map(known + outputs("c"));
  EXPECT_EQ(without.code, 1);
  EXPECT_CONTAINS(without.output, "map_with_known_poses needs poses; add --odometry use");
}

TEST_F(MapRecordingTest, WithoutTimingTwoRunsGiveTheSameBytes) {
  ASSERT_EQ(map("--no-timing" + outputs("a")).code, 0);
  ASSERT_EQ(map("--no-timing" + outputs("b")).code, 0);
  for (const std::string name : kOutputs) {
    EXPECT_EQ(read("a/" + name), read("b/" + name)) << name;
    EXPECT_EQ(read("a/" + name).find(folder_.file("")), std::string::npos) << "a path in " << name;
  }
}

TEST_F(MapRecordingTest, WithTimingOnlyTheTimingDiffers) {
  ASSERT_EQ(map(outputs("a")).code, 0);
  ASSERT_EQ(map("--no-timing" + outputs("b")).code, 0);
  for (const std::string name : {"map.pgm", "map.yaml", "trajectory.tum"}) {
    EXPECT_EQ(read("a/" + name), read("b/" + name)) << name;
  }
  auto stats = nlohmann::ordered_json::parse(read("a/stats.json"));
  EXPECT_EQ(stats.erase("timing"), 1U);
  EXPECT_EQ(stats.dump(2) + "\n", read("b/stats.json"));
}

TEST_F(MapRecordingTest, CommandLineOverridesParameterFile) {
  const std::string yaml = folder_.write("p.yaml", "map_resolution: 0.2\nlaser_max_dist: 20\n");
  const Outcome outcome =
      map("--config " + yaml + " --set map_resolution=0.1 --set clear_range=5" + outputs("out"));
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const auto parameters = nlohmann::json::parse(read("out/stats.json"))["parameters"];
  EXPECT_EQ(parameters["map_resolution"], 0.1);
  EXPECT_EQ(parameters["laser_max_dist"], 20.0);
  EXPECT_EQ(parameters["clear_range"], 5.0);
}

TEST_F(MapRecordingTest, SettingsMayStandBeforeTheRecording) {
  const Outcome outcome = runCommand(kMap + "--set map_resolution=0.1 " + log_ + outputs("out"));
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_EQ(nlohmann::json::parse(read("out/stats.json"))["parameters"]["map_resolution"], 0.1);
}

TEST_F(MapRecordingTest, OutputFolderIsNamedAfterTheRecording) {
  const Outcome outcome = runCommand("cd " + folder_.file("") + " && " + kMap + "flight.clf");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_TRUE(fs::exists(folder_.file("flight_map/map.pgm")));
}

TEST_F(MapRecordingTest, LaserPoseReplacesTheRecordedMounting) {
  ASSERT_EQ(map("--laser-pose 0.3,0,90" + outputs("out")).code, 0);
  const Pose2 last = readTum(folder_.file("out/trajectory.tum")).back().pose;
  EXPECT_NEAR(last.x, 0.0, 0.03);
  EXPECT_NEAR(last.y, 2.0, 0.03);  // forward for the laser is left for the vehicle
}

TEST_F(MapRecordingTest, UsesOdometryOnRequest) {
  ASSERT_EQ(map("--odometry use" + outputs("out")).code, 0);
  EXPECT_EQ(nlohmann::json::parse(read("out/stats.json"))["odometry"], "use");
}

TEST_F(MapRecordingTest, SkipsScansOnRequest) {
  ASSERT_EQ(map("--skip-scans 5 --drop-every 10 --drop-beams 0.2 --scans 30" + outputs("out")).code,
            0);
  const nlohmann::json scans = nlohmann::json::parse(read("out/stats.json"))["scans"];
  EXPECT_EQ(scans["read"], 30);
  EXPECT_EQ(scans["left_out"], 8);  // scans 1 to 5, 10, 20 and 30
  EXPECT_EQ(scans["processed"], 22);
  EXPECT_EQ(scans["lost"], 0);
  ASSERT_EQ(map("--scans 30" + outputs("whole")).code, 0);
  EXPECT_NE(read("out/map.pgm"), read("whole/map.pgm"));
}

TEST_F(MapRecordingTest, QuietPrintsNothing) {
  const Outcome outcome = map("--quiet" + outputs("out"));
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.output, "");
}

TEST_F(MapRecordingTest, BrokenLineIsCountedAndTheOthersAreMapped) {
  std::string text = RoomFlight::carmenLog(10);
  text += text.substr(text.find("FLASER"), 300) + "\n";  // cut off
  const std::string log = folder_.write("broken.clf", text);
  const Outcome outcome = runCommand(kMap + log + outputs("out"));
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_CONTAINS(outcome.output, "warning: ");
  EXPECT_CONTAINS(outcome.output, "10 processed, 1 dropped");
}

TEST_F(MapRecordingTest, WritesResultsAfterAnInterrupt) {
  constexpr int kLong = 3000;
  const std::string log = folder_.write("long.clf", RoomFlight::carmenLog(kLong));
  // Sends the signal as soon as the output folder exists, just before mapping. The exhaustive
  // matcher makes mapping slow enough.
  const Outcome outcome =
      runCommand("sh -c '" + kMap + log + " --set matcher=correlative" + outputs("out") +
                 " & pid=$!; until [ -d " + folder_.file("out") +
                 " ]; do :; done; kill -INT $pid; wait $pid'");
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_CONTAINS(outcome.output, "warning: stopped early, after ");
  for (const char* name : kOutputs) EXPECT_TRUE(fs::exists(folder_.file("out/") + name)) << name;
}

TEST_F(MapRecordingTest, AKilledRunLeavesAllFilesOfOneRun) {
  const std::string short_run = "--scans 3 --quiet" + outputs("out") + " --set map_resolution=";
  ASSERT_EQ(map(short_run + "0.05").code, 0);
  for (int i = 0; i < 30; ++i) {
    const std::string other = i % 2 == 0 ? "0.1" : "0.05";
    runCommand("timeout -s KILL " + std::to_string(0.01 + 0.005 * (i % 13)) + " " + kMap + log_ +
               " " + short_run + other);
    const double resolution = readMap(folder_.file("out/map.yaml")).resolution_m;
    EXPECT_EQ(nlohmann::json::parse(read("out/stats.json"))["parameters"]["map_resolution"],
              resolution);
    for (const char* name : kOutputs) EXPECT_TRUE(fs::exists(folder_.file("out/") + name)) << name;
  }
  ASSERT_EQ(map(short_run + "0.05").code, 0);
  const fs::directory_iterator files(folder_.file("")), end;
  EXPECT_EQ(std::distance(files, end), 2) << "a killed run left something beside log and output";
}

TEST_F(MapRecordingTest, BadInputIsOneLineAndExitCodeOne) {
  const std::string garbage = folder_.write("garbage.bag", "\x01\x02 nothing of use\n");
  const std::string bad_yaml = folder_.write("bad.yaml", "matcher: fast\n");
  const std::string file = folder_.write("file", "");
  const struct {
    std::string arguments, words;
  } cases[] = {
      {folder_.file("missing.bag"), "missing.bag"},
      {folder_.file(""), "folder"},
      {file, "the file is empty (0 bytes)"},
      {garbage, "unknown format; use a rosbag, a CARMEN log"},
      {log_ + " --set map_resolutoin=0.1", "did you mean 'map_resolution'?"},
      {log_ + " --set map_resolution=-1", "map_resolution = -1: must be between"},
      {log_ + " --set map_resolution", "must be name=value"},
      {log_ + " --set laser_min_dist=90", "laser_min_dist = 90: must be less than laser_max_dist"},
      {log_ + " --config " + bad_yaml, "bad.yaml, line 1: matcher = fast: must be one of"},
      {log_ + " --config " + folder_.file("none.yaml"), "none.yaml"},
      {log_ + " --output " + file, "it is a file, not a folder; choose another --output"},
      {log_ + " --output " + file + "/out", "cannot create the output folder"},
      {log_ + " --output /proc/kestrel", "cannot create the output folder /proc/kestrel"},
  };
  for (const auto& [arguments, words] : cases) {
    const Outcome outcome = runCommand(kMap + arguments);
    EXPECT_EQ(outcome.code, 1) << arguments;
    EXPECT_EQ(outcome.output.rfind("map_recording: ", 0), 0U) << outcome.output;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
    EXPECT_CONTAINS(outcome.output, words);
  }
}

TEST_F(MapRecordingTest, UnwritableOutputFolderIsReportedBeforeMapping) {
  const Outcome outcome = map("--output /proc/kestrel");
  EXPECT_EQ(outcome.output.find("scans"), std::string::npos)
      << "mapping started: " << outcome.output;
}

TEST_F(MapRecordingTest, WrongUsageIsExitCodeTwo) {
  EXPECT_EQ(runCommand(kMap).code, 2);
  EXPECT_EQ(map("--nonsense").code, 2);
  EXPECT_EQ(map("--odometry perhaps").code, 2);
  EXPECT_EQ(map("--output").code, 2);
  EXPECT_EQ(map("--drop-every 0").code, 2);
  EXPECT_EQ(map("--drop-beams 1.5").code, 2);
}

TEST_F(MapRecordingTest, HelpFitsIntoEightyColumns) {
  std::istringstream help(runCommand(kMap + "--help").output);
  int lines = 0;
  for (std::string line; std::getline(help, line); ++lines) EXPECT_LE(line.size(), 80U) << line;
  EXPECT_GT(lines, 30);
}

TEST_F(MapRecordingTest, PipedOutputHasThreeLinesOfProgress) {
  const std::string output = map(outputs("out")).output;
  std::size_t lines = 0;
  for (std::size_t at = 0; (at = output.find(" left\n", at)) != std::string::npos; ++at) ++lines;
  EXPECT_EQ(lines, 3U) << output;
}

TEST_F(MapRecordingTest, FieldOfViewOfATable) {
  std::string table;
  for (int i = 0; i < kScans; ++i) {
    const LaserScan scan = RoomFlight::scan(i);
    for (std::size_t b = 0; b < scan.ranges.size(); ++b) {
      table += (b == 0 ? "" : ";") + std::to_string(scan.ranges[b]);
    }
    table += "\n";
  }
  const std::string path = folder_.write("room.csv", table);
  const Outcome outcome = runCommand(kMap + path + " --fov 179 --rate 10" + outputs("out"));
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_NEAR(readTum(folder_.file("out/trajectory.tum")).back().pose.x, 2.0, 0.05);
  EXPECT_EQ(runCommand(kMap + path + " --fov 400" + outputs("out")).code, 2);
}

TEST_F(MapRecordingTest, RangesInMillimetersAreTheReason) {
  std::string log = "# CARMEN Logfile\n";
  for (int i = 0; i < kScans; ++i) {
    log += "FLASER 180";
    for (const float range : RoomFlight::scan(i).ranges)
      log += ' ' + std::to_string(1000.0F * range);
    log += " 0 0 0 0 0 0 " + std::to_string(0.1 * i) + " host 0\n";
  }
  const Outcome outcome = runCommand(kMap + folder_.write("mm.clf", log) + outputs("out"));
  EXPECT_EQ(outcome.code, 1);
  EXPECT_CONTAINS(outcome.output, "41 of 41");
}

TEST_F(MapRecordingTest, HelpVersionAndParametersNeedNoRecording) {
  EXPECT_EQ(runCommand(kMap + "--help").code, 0);
  EXPECT_EQ(runCommand(kMap + "--version").output, std::string(kVersion) + "\n");
  EXPECT_EQ(runCommand(kMap + "--list-parameters").output, defaultParametersYaml());
}

}  // namespace
}  // namespace kestrel
