// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/panel/mapper_summary.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

using Values = std::vector<std::pair<std::string, std::string>>;

diagnostic_msgs::DiagnosticStatus statusOf(const std::string& name, int level,
                                           const std::string& message, const Values& values) {
  diagnostic_msgs::DiagnosticStatus status;
  status.name = name;
  status.level = static_cast<signed char>(level);
  status.message = message;
  for (const auto& [key, value] : values) {
    diagnostic_msgs::KeyValue entry;
    entry.key = key;
    entry.value = value;
    status.values.push_back(entry);
  }
  return status;
}

diagnostic_msgs::DiagnosticArray mapperMessage(const std::string& node) {
  diagnostic_msgs::DiagnosticArray message;
  message.status = {
      statusOf(node + ": Scans", 1, "3 scans dropped recently, the last one: overload",
               {{"received", "20"},
                {"used", "17"},
                {"dropped: overload", "3"},
                {"ms per scan, mean", "2.5"}}),
      statusOf(node + ": Match", 2, "lost", {{"state", "lost"}, {"reason", "fits nowhere"}}),
      statusOf(node + ": Map", 0, "ok",
               {{"width (m)", "12.345"},
                {"height (m)", "8.0"},
                {"memory (MB)", "1.5"},
                {"loops closed", "3"},
                {"loops refused", "1"}}),
      statusOf("/tracker: Tracker", 0, "scans are tracked", {{"moving objects", "2"}})};
  return message;
}

TEST(MapperSummaryTest, SaysStateReasonDropsAndMap) {
  MapperSummary summary;
  ASSERT_TRUE(takeOver(mapperMessage("mapper"), "", summary));
  EXPECT_EQ(summary.node, "/mapper");
  EXPECT_EQ(summary.state, "lost");
  EXPECT_EQ(summary.reason, "fits nowhere");
  EXPECT_EQ(summary.problem, "3 scans dropped recently, the last one: overload");
  EXPECT_EQ(summary.used, 17.0);
  EXPECT_EQ(summary.ms, 2.5);
  EXPECT_EQ(summary.dropped, (Values{{"overload", "3"}}));
  EXPECT_EQ(summary.map, "12.3 m x 8.0 m, 1.5 MB");
  EXPECT_EQ(summary.loops, "3 closed, 1 refused");
  EXPECT_EQ(summary.tracks, "2");
}

TEST(MapperSummaryTest, APauseHidesTheLastMatch) {
  diagnostic_msgs::DiagnosticArray message = mapperMessage("/mapper");
  message.status[0] = statusOf("/mapper: Scans", 0, "paused", {});
  MapperSummary summary;
  ASSERT_TRUE(takeOver(message, "/mapper", summary));
  EXPECT_EQ(summary.state, "paused");
  EXPECT_EQ(summary.problem, "");
  EXPECT_TRUE(summary.dropped.empty());
}

TEST(MapperSummaryTest, TheTrackerOfAnotherVehicleIsIgnored) {
  diagnostic_msgs::DiagnosticArray message = mapperMessage("/uav1/mapper");
  message.status.back().name = "/uav2/tracker: Tracker";
  MapperSummary summary;
  ASSERT_TRUE(takeOver(message, "/uav1/mapper", summary));
  EXPECT_EQ(summary.tracks, "");
  message.status.back().name = "/uav1/tracker: Tracker";
  ASSERT_TRUE(takeOver(message, "/uav1/mapper", summary));
  EXPECT_EQ(summary.tracks, "2");
}

TEST(MapperSummaryTest, OtherNodesAreIgnored) {
  MapperSummary summary;
  EXPECT_FALSE(takeOver(mapperMessage("/uav2/mapper"), "/uav1/mapper", summary));
  diagnostic_msgs::DiagnosticArray projector;
  projector.status = {statusOf("/projector: Scans", 0, "ok", {{"received", "5"}})};
  EXPECT_FALSE(takeOver(projector, "", summary));
  EXPECT_EQ(summary.node, "");
}

}  // namespace
}  // namespace kestrel
