// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "../merging/building.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/merging/merged_session.h"
#include "kestrel_slam/session/session_file.h"
#include "run_command.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// The session of one vehicle.
void saveFlight(const std::string& path, const building::Variant& variant, int first, int last,
                std::size_t keyframes = 0) {
  VehicleMap map = building::mapOf("x", variant, building::tour(first, last));
  if (keyframes > 0) map = building::beginOf(map, keyframes);
  MapMerger merger{MapperConfig(), LoopConfig()};
  merger.update(map);
  saveSession(path, mergedSession(merger.vehicles(), merger.merge(), 0));
}

class MergeSessions : public testing::Test {
 protected:
  MergeSessions() {
    saveFlight(a_, {}, 0, 2);
    saveFlight(b_, {}, 2, 0);
  }

  Outcome merge(const std::string& arguments) const {
    return runCommand(std::string(KESTREL_TOOL_DIR) + "/merge_sessions " + arguments);
  }

  TemporaryFolder folder_;
  std::string a_ = folder_.file("a.session"), b_ = folder_.file("b.session");
};

TEST_F(MergeSessions, WritesOneMapAndTheSameBytesTwice) {
  const std::string first = folder_.file("first"), second = folder_.file("second");
  const Outcome result = merge(a_ + " " + b_ + " --output " + first);
  ASSERT_EQ(result.code, 0) << result.output;
  EXPECT_NE(result.output.find("a and b: joined"), std::string::npos) << result.output;
  ASSERT_EQ(merge(a_ + " " + b_ + " --output " + second).code, 0);
  for (const char* file : {"merged.session", "map.pgm", "map.yaml", "merge_status.json",
                           "trajectory_a.tum", "trajectory_b.tum", "report.html"}) {
    EXPECT_EQ(readFile(first + "/" + file), readFile(second + "/" + file)) << file;
  }
  EXPECT_TRUE(std::filesystem::exists(first + "/merged.png"));
  const Session merged = loadSession(first + "/merged.session");
  EXPECT_EQ(merged.keyframes.size(),
            loadSession(a_).keyframes.size() + loadSession(b_).keyframes.size());
}

TEST_F(MergeSessions, TheCacheChangesNothing) {
  const std::string plain = folder_.file("plain"), cached = folder_.file("cached");
  ASSERT_EQ(merge(a_ + " " + b_ + " --output " + plain).code, 0);
  const std::string cache = folder_.file("cache");
  const std::string arguments = a_ + " " + b_ + " --cache " + cache + " --output " + cached;
  ASSERT_EQ(merge(arguments).code, 0);
  const std::string first = readFile(cache);
  for (const bool damaged : {false, true}) {
    if (damaged) folder_.write("cache", first.substr(0, first.size() / 2));
    ASSERT_EQ(merge(arguments).code, 0);
    EXPECT_EQ(readFile(cache), first);
    for (const char* file : {"merged.session", "map.pgm", "merge_status.json", "trajectory_b.tum"})
      EXPECT_EQ(readFile(plain + "/" + file), readFile(cached + "/" + file)) << file;
  }
}

/// A vehicle of the last merge_status.json.
nlohmann::json vehicleOf(const nlohmann::json& status, const std::string& name) {
  for (const nlohmann::json& vehicle : status["vehicles"])
    if (vehicle["name"] == name) return vehicle;
  return {};
}

std::string stateOf(const nlohmann::json& status, const std::string& a, const std::string& b) {
  for (const nlohmann::json& pair : status["pairs"])
    if ((pair["a"] == a && pair["b"] == b) || (pair["a"] == b && pair["b"] == a))
      return pair["state"];
  return "";
}

/// A mission whose vehicles are restarted: they begin new flights under their old names.
class MergeSessionsAgain : public MergeSessions {
 protected:
  nlohmann::json mergeAgain(const std::string& arguments) {
    const Outcome result = merge(arguments + " --before " + folder_.file("out/merge_status.json") +
                                 " --output " + folder_.file("out"));
    EXPECT_EQ(result.code, 0) << result.output;
    return nlohmann::json::parse(readFile(folder_.file("out/merge_status.json")));
  }
};

TEST_F(MergeSessionsAgain, WorldStaysWhenTheFirstVehicleIsRestarted) {
  const nlohmann::json before = mergeAgain("a=" + a_ + " b=" + b_);
  ASSERT_EQ(stateOf(before, "a", "b"), "joined");
  // The new map of a is still too small for anything.
  const std::string small = folder_.file("small.session");
  saveFlight(small, {}, 1, 1, 8);
  nlohmann::json after = mergeAgain("a=" + small + " b=" + b_ + " a_before=" + a_);
  EXPECT_EQ(vehicleOf(after, "b")["world_T_map"], vehicleOf(before, "b")["world_T_map"]);
  EXPECT_EQ(after["vehicles"][0]["name"], "a_before");
  EXPECT_EQ(loadSession(folder_.file("out/merged.session")).keyframes.size(),
            loadSession(a_).keyframes.size() + loadSession(b_).keyframes.size());
  // After another restart, the flight whose map was `world` is gone.
  for (int i = 0; i < 2; ++i) {
    after = mergeAgain("a=" + small + " b=" + b_);
    EXPECT_EQ(after["vehicles"][0]["name"], "b");
    for (const char* of : {"x", "y", "yaw"})
      EXPECT_NEAR(double(vehicleOf(after, "b")["world_T_map"][of]),
                  double(vehicleOf(before, "b")["world_T_map"][of]), 0.02)
          << of;
  }
}

TEST_F(MergeSessionsAgain, WhatTheUserSaidIsTrueForTheFlightsOfThen) {
  const std::string east = folder_.file("east.session"), west = folder_.file("west.session");
  saveFlight(west, {}, 0, 0);
  saveFlight(east, {}, 2, 2);
  const std::string starts = " --start a=0,0,0 --start b=16,0,0";
  nlohmann::json status = mergeAgain("a=" + west + " b=" + east + starts);
  EXPECT_EQ(stateOf(status, "a", "b"), "given");
  // A new flight does not begin where the first one began: nobody knows where it is.
  const std::string next = folder_.file("next.session");
  saveFlight(next, {}, 1, 1);
  status = mergeAgain("a=" + west + " b=" + next + " b_before=" + east + starts);
  EXPECT_EQ(stateOf(status, "a", "b_before"), "given");
  EXPECT_NE(stateOf(status, "a", "b"), "given");
  status =
      mergeAgain("a=" + west + " b=" + next + " b_before=" + east + starts + " --join b=8,0,0");
  EXPECT_EQ(stateOf(status, "a", "b"), "given");
  // The next mission, with the same folder and the same starts.
  building::Variant elsewhere;
  elsewhere.other_place = true;
  saveFlight(west, elsewhere, 0, 0);
  saveFlight(east, elsewhere, 2, 2);
  EXPECT_EQ(stateOf(mergeAgain("a=" + west + " b=" + east + starts), "a", "b"), "given");
}

TEST_F(MergeSessionsAgain, SeparatedFlightsStaySeparatedUntilTheyAreJoined) {
  const std::string both = "a=" + a_ + " b=" + b_;
  EXPECT_EQ(stateOf(mergeAgain(both + " --separate a,b"), "a", "b"), "separated");
  EXPECT_EQ(stateOf(mergeAgain(both), "a", "b"), "separated") << "a merger that was restarted";
  EXPECT_EQ(stateOf(mergeAgain("a=" + a_ + " c=" + b_), "a", "c"), "separated") << "renamed";
  EXPECT_EQ(stateOf(mergeAgain(both + " --join b=16,0,0"), "a", "b"), "joined");
  EXPECT_EQ(stateOf(mergeAgain(both), "a", "b"), "joined");
  EXPECT_EQ(
      merge(both + " --before " + folder_.write("bad", "{") + " --output " + folder_.file("out"))
          .code,
      1);
}

TEST_F(MergeSessions, BadInputIsSaid) {
  const std::string output = " --output " + folder_.file("out");
  Outcome result = merge(a_ + " a=" + b_ + output);
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.output.find("two vehicles are called a"), std::string::npos) << result.output;
  result = merge(a_ + " again=" + a_ + output);
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.output.find("same flight"), std::string::npos) << result.output;
  EXPECT_EQ(merge(a_ + output).code, 2) << "one session";
  EXPECT_EQ(merge(a_ + " " + folder_.write("bad", "no session") + output).code, 1);
}

}  // namespace
}  // namespace kestrel
