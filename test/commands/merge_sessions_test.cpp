// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>

#include "../merging/building.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/merging/merged_session.h"
#include "kestrel_slam/session/session_file.h"
#include "run_command.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

/// The session of one vehicle.
void saveFlight(const std::string& path, const building::Variant& variant, int first, int last) {
  const VehicleMap map = building::mapOf("x", variant, building::tour(first, last));
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
