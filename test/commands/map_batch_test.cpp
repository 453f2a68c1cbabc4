// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "kestrel_slam/map/atomic_file.h"
#include "room_log_test.h"
#include "run_command.h"

namespace kestrel {
namespace {

const std::string kBatch =
    "KESTREL_TOOLS=" KESTREL_TOOL_DIR " " KESTREL_SOURCE_DIR "/scripts/map_batch ";

/// Three flights through the room and one broken log, with real programs. The supervision is tested
/// in test/scripts/map_batch_test.py.
TEST(MapBatchTest, MapsAFolderAndComparesItWithTheFirstResult) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.file("logs"));
  const std::string log = RoomFlight::carmenLog(10);
  const std::string log_a = folder.write("logs/a.clf", log);
  folder.write("logs/b.txt", log);  // found by its content
  folder.write("logs/notes.txt", "not a recording\n");
  folder.write("logs/broken.clf", "FLASER 3 1\n");
  std::string relation = std::to_string(RoomFlight::stamp(0)) + " " +
                         std::to_string(RoomFlight::stamp(9)) + " 0.45 0 0 0 0 0\n";
  folder.write("logs/a.relations", relation);

  const std::string call = kBatch + folder.file("logs") + " --set map_resolution=0.1 --output ";
  const Outcome first = runCommand(call + folder.file("old"));
  EXPECT_EQ(first.code, 1) << first.output;
  EXPECT_CONTAINS(first.output, "2 of 3 recordings mapped");
  const auto rows = nlohmann::json::parse(readFile(folder.file("old/summary.json")))["recordings"];
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0]["scans"], 10);
  EXPECT_NEAR(rows[0]["relations_m"].get<double>(), 0.0, 0.03);
  EXPECT_EQ(rows[1]["relations_m"], nullptr);
  EXPECT_EQ(rows[0]["input_hash"], rows[1]["input_hash"]);
  EXPECT_EQ(rows[2]["status"], "failed");
  for (const char* file : {"map.pgm", "report.html", "thumbnail.png", "evaluation.json"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.file("old/maps/a/") + file)) << file;
  }

  const Outcome again = runCommand(call + folder.file("new") + " --max-failed 1 --compare " +
                                   folder.file("old") + " --max-relations 0.1");
  EXPECT_EQ(again.code, 0) << again.output;
  EXPECT_CONTAINS(again.output, "0 worse, 0 better, 3 compared");
  const Outcome counted =
      runCommand(kBatch + log_a + " --scans 9 --instructions 2 --output " + folder.file("counted"));
  if (runCommand("valgrind --version").code == 0) {
    ASSERT_EQ(counted.code, 0) << counted.output;
    const auto row =
        nlohmann::json::parse(readFile(folder.file("counted/summary.json")))["recordings"][0];
    ASSERT_TRUE(row["instructions_million"].is_number()) << row;
    EXPECT_GT(row["instructions_million"].get<double>(), 10.0);
    EXPECT_EQ(row["scans"], 9);
  }
  const Outcome wrong = runCommand(kBatch + folder.file("logs") + " --set nonsense=1 --output " +
                                   folder.file("wrong"));
  EXPECT_EQ(wrong.code, 1);
  EXPECT_CONTAINS(wrong.output, "nonsense");
  EXPECT_EQ(runCommand(kBatch + "--nonsense").code, 2);
}

}  // namespace
}  // namespace kestrel
