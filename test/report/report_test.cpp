// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "report/page_data.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

OfflineRun runOf(std::size_t scans) {
  OfflineRun run;
  for (std::size_t i = 0; i < scans; ++i) {
    const double angle = 0.01 * static_cast<double>(i);
    ScanRecord scan;
    scan.time = 100.0 + 0.1 * static_cast<double>(i);
    scan.state = i == 3 ? MatchState::kLost : MatchState::kOk;
    scan.score = i == 3 ? 0.125 : 0.9;
    scan.known = i == 3 ? 0.25 : 1.0;
    scan.constraint = i == 3 ? 0.0045 : 0.3;
    scan.reason = i == 3 ? "no fit" : "fits";
    scan.ms = 0.5;
    run.scans.push_back(scan);
    run.trajectory.push_back({scan.time, Pose2(std::cos(angle), std::sin(angle), angle)});
  }
  run.map.resolution_m = 0.5;
  run.map.origin_x = -1.0;
  run.map.origin_y = -2.0;
  run.map.width = 2;
  run.map.height = 1;
  run.map.cells = {0, 100};
  run.processing_s = 1.25;
  run.peak_memory_mb = 12.0;
  return run;
}

RunInfo infoOf(bool timing) {
  RunInfo info;
  info.recording = "flight.bag";
  info.timing = timing;
  return info;
}

TEST(ReportTest, NeedsNothingFromTheNetwork) {
  const std::string html = reportHtml(runOf(10), infoOf(true));
  EXPECT_EQ(html.rfind("<!DOCTYPE html>", 0), 0U);
  for (const char* reference : {"http:", "https:", "src=", "href=", "@import", "url("}) {
    EXPECT_EQ(html.find(reference), std::string::npos) << reference;
  }
}

TEST(ReportTest, ContainsMapPathAndCharts) {
  const auto data = dataOf(reportHtml(runOf(10), infoOf(true)));
  EXPECT_EQ(data["map"]["width"], 2);
  EXPECT_EQ(data["map"]["metersPerPixel"], 0.5);
  EXPECT_EQ(data["map"]["originY"], -2.0);
  EXPECT_EQ(data["map"]["png"].get<std::string>().rfind("data:image/png;base64,iVBORw0KGgo", 0),
            0U);
  EXPECT_EQ(data["path"]["t"].size(), 10U);
  EXPECT_EQ(data["path"]["t"][4], 0.4);
  EXPECT_EQ(data["path"]["state"].dump(), "[0,0,0,2,0,0,0,0,0,0]");
  EXPECT_EQ(data["path"]["reason"][3], "no fit");
  ASSERT_EQ(data["charts"].size(), 6U);
  EXPECT_EQ(data["charts"][0]["title"], "Match quality");
  EXPECT_EQ(data["charts"][0]["v"][3], 0.125);
  EXPECT_EQ(data["charts"][4]["unit"], "m/s");
  EXPECT_EQ(data["charts"][5]["v"][9], 0.1);  // 0.01 rad every 0.1 s
}

TEST(ReportTest, ShowsOverlapAndConstraintOverTime) {
  const auto data = dataOf(reportHtml(runOf(10), infoOf(true)));
  const auto &overlap = data["charts"][1], &constraint = data["charts"][2];
  EXPECT_EQ(overlap["title"].get<std::string>().rfind("Overlap", 0), 0U);
  EXPECT_EQ(overlap["v"][3], 0.25);
  EXPECT_EQ(overlap["high"], 1.0);
  EXPECT_EQ(constraint["title"].get<std::string>().rfind("Constraint", 0), 0U);
  EXPECT_EQ(constraint["v"][3], 0.0045);
  EXPECT_EQ(constraint["high"], 0.5);
}

TEST(ReportTest, CountsTheReasonsOfTheStates) {
  OfflineRun run = runOf(10);
  run.scans[5].state = run.scans[7].state = MatchState::kDegraded;
  run.scans[5].reason = run.scans[7].reason = "settling";
  const auto reasons = dataOf(reportHtml(run, infoOf(true)))["reasons"];
  ASSERT_EQ(reasons.size(), 3U);
  EXPECT_EQ(reasons[0].dump(), R"({"first":0.0,"reason":"fits","scans":7,"state":"ok"})");
  EXPECT_EQ(reasons[1].dump(), R"({"first":0.5,"reason":"settling","scans":2,"state":"degraded"})");
  EXPECT_EQ(reasons[2].dump(), R"({"first":0.3,"reason":"no fit","scans":1,"state":"lost"})");
}

TEST(ReportTest, LongRunIsReducedButKeepsItsWorstScan) {
  const std::string html = reportHtml(runOf(30000), infoOf(true));
  const auto data = dataOf(html);
  EXPECT_LE(data["charts"][0]["v"].size(), 5000U);
  EXPECT_LE(data["path"]["x"].size(), 5010U);
  const std::vector<double> quality = data["charts"][0]["v"];
  EXPECT_EQ(*std::min_element(quality.begin(), quality.end()), 0.125);
  const std::vector<int> states = data["path"]["state"];
  EXPECT_EQ(std::count(states.begin(), states.end(), 2), 1);
  EXPECT_EQ(data["path"]["t"].back(), 2999.9);
  EXPECT_LT(html.size(), 1000000U);
}

TEST(ReportTest, WithoutTimingNoMeasuredValueIsWritten) {
  OfflineRun slow = runOf(10);
  slow.processing_s = 99.0;
  slow.peak_memory_mb = 999.0;
  for (ScanRecord& scan : slow.scans) scan.ms = 77.0;
  EXPECT_NE(reportHtml(runOf(10), infoOf(true)), reportHtml(slow, infoOf(true)));
  EXPECT_EQ(reportHtml(runOf(10), infoOf(false)), reportHtml(slow, infoOf(false)));
}

TEST(ReportTest, ShowsThePoseFilterAndThePartsOfTheTime) {
  OfflineRun run = runOf(10);
  EXPECT_EQ(dataOf(reportHtml(run, infoOf(true)))["charts"].size(), 6U) << "without filter";
  for (ScanRecord& scan : run.scans) {
    scan.stage_ms = {0.05, 0.1, 0.3, 0.05};
    scan.filter = FilterSample{1.5, 0.1, 0.01, 0.2};
  }
  run.scans.front().filter.reset();  // before it was initialized
  const nlohmann::json data = dataOf(reportHtml(run, infoOf(true)));
  ASSERT_EQ(data["charts"].size(), 10U);
  EXPECT_EQ(data["charts"][6]["title"], "Filter: height");
  EXPECT_EQ(data["charts"][6]["t"][0], 0.1);
  EXPECT_EQ(data["charts"][7]["v"][0], 5.73);
  EXPECT_NE(data["rows"].dump().find("matching 0.300 ms"), std::string::npos);
}

TEST(ReportTest, ShowsWhatMoved) {
  OfflineRun run = runOf(10);
  for (ScanRecord& scan : run.scans) scan.tracker = TrackerSample{2.0, 0.25};
  const nlohmann::json data = dataOf(reportHtml(run, infoOf(true)));
  ASSERT_EQ(data["charts"].size(), 8U);
  EXPECT_EQ(data["charts"][6]["title"], "Tracker: moving objects");
  EXPECT_EQ(data["charts"][6]["v"][0], 2.0);
  EXPECT_EQ(data["charts"][7]["v"][0], 0.25);
}

TEST(ReportTest, MarksChangedParameters) {
  RunInfo info = infoOf(true);
  setParameter(info.config, "map_resolution", "0.1");
  for (const auto& row : dataOf(reportHtml(runOf(2), info))["parameters"]) {
    EXPECT_EQ(row["value"] != row["standard"], row["name"] == "map_resolution") << row.dump();
  }
}

TEST(ReportTest, OpensOnTheWalls) {
  EXPECT_EQ(dataOf(reportHtml(runOf(2), infoOf(true)))["map"]["walls"].dump(),
            "[-0.5,-2.0,0.0,-1.5]");
  EXPECT_TRUE(dataOf(reportHtml(OfflineRun(), infoOf(true)))["map"]["walls"].is_null());
}

TEST(ReportTest, UnchangedParametersAreFoldedAndThePageCanBePrinted) {
  const std::string html = reportHtml(runOf(2), infoOf(true));
  EXPECT_LT(html.find("<table id=\"changed\""), html.find("<details>"));
  EXPECT_LT(html.find("<details>"), html.find("<table id=\"parameters\""));
  EXPECT_CONTAINS(html, "@media print");
}

TEST(ReportTest, FileNameCannotBreakThePage) {
  RunInfo info = infoOf(true);
  info.recording = "</script><b>\"&\xff.bag";
  const std::string html = reportHtml(runOf(2), info);
  EXPECT_EQ(html.find("</script><b>"), std::string::npos);
  EXPECT_EQ(dataOf(html)["title"], "</script><b>\"&\xef\xbf\xbd.bag");
}

TEST(ReportTest, EmptyRunGivesAPage) {
  const auto data = dataOf(reportHtml(OfflineRun(), infoOf(true)));
  EXPECT_EQ(data["map"]["width"], 0);
  EXPECT_TRUE(data["path"]["t"].empty());
}

}  // namespace
}  // namespace kestrel
