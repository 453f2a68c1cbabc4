// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/stats.h"

#include <gtest/gtest.h>

#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/offline/provenance.h"
#include "kestrel_slam/session/version.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

ScanRecord scanOf(double time, MatchState state, double score, double ms) {
  ScanRecord scan;
  scan.time = time;
  scan.state = state;
  scan.score = score;
  scan.ms = ms;
  scan.inserted = state == MatchState::kOk;
  scan.searched = state != MatchState::kOk;
  return scan;
}

OfflineRun smallRun() {
  OfflineRun run;
  run.scans = {scanOf(0, MatchState::kOk, 1.0, 1.0), scanOf(1, MatchState::kOk, 0.75, 2.0),
               scanOf(2, MatchState::kDegraded, 0.5, 3.0),
               scanOf(3, MatchState::kLost, 0.25, 10.0)};
  run.trajectory.resize(4);
  run.dropped = {{"no-valid-beam", 2}, {"broken line", 1}};
  run.warnings = {"something happened"};
  run.distance_m = 12.3456;
  run.duration_s = 3.0;
  run.processing_s = 0.5;
  run.peak_memory_mb = 33.33;
  run.map_memory_bytes = 3 * 1024 * 1024;
  run.map.resolution_m = 0.5;
  run.map.width = 3;
  run.map.height = 2;
  run.map.cells = {-1, 0, 100, 0, -1, -1};
  return run;
}

RunInfo infoOf(bool timing) {
  RunInfo info;
  info.recording = "flight.bag";
  info.description = "a bag";
  info.timing = timing;
  return info;
}

TEST(DistributionTest, ExactValues) {
  std::vector<double> values;
  for (int i = 200; i >= 1; --i) values.push_back(i);
  const Distribution all = distributionOf(values);
  EXPECT_DOUBLE_EQ(all.mean, 100.5);
  EXPECT_DOUBLE_EQ(all.median, 100.5);
  EXPECT_DOUBLE_EQ(all.p99, 198.0);  // 198 of 200 values are at most this
  EXPECT_DOUBLE_EQ(all.max, 200.0);
  const Distribution one = distributionOf({7.0});
  EXPECT_EQ(one.median, 7.0);
  EXPECT_EQ(one.p99, 7.0);
  EXPECT_EQ(distributionOf({3.0, 1.0, 2.0}).median, 2.0);
  EXPECT_EQ(distributionOf({}).max, 0.0);
}

TEST(StatsTest, CountsAndShares) {
  const auto stats = statsOf(smallRun(), infoOf(true));
  EXPECT_EQ(stats["scans"].dump(),
            R"({"read":7,"processed":4,"dropped":{"broken line":1,"no-valid-beam":2},"left_out":0,)"
            R"("inserted":2,"searched":2,"lost":1})");
  EXPECT_EQ(stats["match"].dump(),
            R"({"quality_mean":0.625,"quality_min":0.25,"share_ok":0.5,"share_degraded":0.25,)"
            R"("share_lost":0.25})");
  EXPECT_EQ(stats["map"].dump(),
            R"({"resolution_m":0.5,"width_cells":3,"height_cells":2,"width_m":1.5,"height_m":1.0,)"
            R"("known_area_m2":0.8,"memory_mb":3.0})");
  EXPECT_EQ(stats["timing"].dump(),
            R"({"ms_per_scan":{"mean":4.0,"median":2.5,"p99":10.0,"max":10.0,)"
            R"("median_first_quarter":1.0,"median_last_quarter":10.0},)"
            R"("stages_ms":{"filter":{"mean":0.0,"p99":0.0},"projection":{"mean":0.0,"p99":0.0},)"
            R"("matching":{"mean":0.0,"p99":0.0},"graph":{"mean":0.0,"p99":0.0}},)"
            R"("processing_s":0.5,"speed_factor":6.0,"peak_memory_mb":33.3})");
  EXPECT_EQ(stats["distance_m"], 12.346);
  EXPECT_EQ(stats["duration_s"], 3.0);
  EXPECT_EQ(stats["recording"]["name"], "flight.bag");
  EXPECT_EQ(stats["odometry"], "none");
  EXPECT_EQ(stats["version"], kVersion);
  EXPECT_EQ(stats["warnings"].dump(), R"(["something happened"])");
}

TEST(StatsTest, TheHashOfTheParametersChangesWithParametersAndOptions) {
  const auto hashOf = [](const RunInfo& info) {
    return statsOf(smallRun(), info)["parameters_hash"];
  };
  const RunInfo plain = infoOf(true);
  RunInfo other_parameter = plain, other_option = plain, other_file = plain;
  other_parameter.config.mapper.grid.resolution_m = 0.1;
  other_option.options = {{"--odometry", "use"}};
  other_file.hash = "1";
  EXPECT_NE(hashOf(plain), hashOf(other_parameter));
  EXPECT_NE(hashOf(plain), hashOf(other_option));
  EXPECT_EQ(hashOf(plain), hashOf(other_file));
  EXPECT_EQ(statsOf(smallRun(), other_file)["recording"]["hash"], "1");
  EXPECT_EQ(statsOf(smallRun(), plain)["commit"], builtCommit());
}

TEST(ProvenanceTest, HashesAreThoseOfXxh128sum) {
  // printf abc | xxh128sum
  EXPECT_EQ(hashOfText("abc"), "06b05ab6733a618578af5f94892f3950");
  const TemporaryFolder folder;
  const std::string a = folder.write("a", "ab"), b = folder.write("b", "c");
  EXPECT_EQ(hashOfFiles({b, a}), hashOfText("abc")) << "in the order of the names";
  EXPECT_CONTAINS(messageOf([&] { hashOfFiles({folder.file("none")}); }), "cannot read ");
}

TEST(StatsTest, ContainsEveryParameterWithItsType) {
  RunInfo info = infoOf(true);
  info.config.mapper.grid.resolution_m = 0.1;
  const auto parameters = statsOf(smallRun(), info)["parameters"];
  EXPECT_EQ(parameters.size(), parametersOf(info.config).size());
  EXPECT_EQ(parameters["map_resolution"], 0.1);
  EXPECT_TRUE(parameters["max_beams"].is_number_integer());
  EXPECT_TRUE(parameters["matcher"].is_string());
}

TEST(StatsTest, WithoutTimingNoMeasuredValueRemains) {
  OfflineRun slow = smallRun();
  slow.processing_s = 99.0;
  slow.peak_memory_mb = 999.0;
  for (ScanRecord& scan : slow.scans) scan.ms = 77.0;
  EXPECT_NE(statsOf(smallRun(), infoOf(true)), statsOf(slow, infoOf(true)));
  EXPECT_EQ(statsOf(smallRun(), infoOf(false)).dump(), statsOf(slow, infoOf(false)).dump());
  EXPECT_FALSE(statsOf(slow, infoOf(false)).contains("timing"));
}

TEST(StatsTest, AnEmptyRunHasNoNan) {
  const std::string text = statsOf(OfflineRun(), infoOf(true)).dump();
  EXPECT_EQ(text.find("null"), std::string::npos) << text;
}

TEST(VersionTest, EqualsThatOfPackageXml) {
  EXPECT_CONTAINS(readFile(KESTREL_SOURCE_DIR "/package.xml"),
                  "<version>" + std::string(kVersion) + "</version>");
}

}  // namespace
}  // namespace kestrel
