// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <string>

#include "kestrel_slam/graph/g2o_file.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/map/map_io.h"
#include "kestrel_slam/recording/trajectory.h"
#include "kestrel_slam/session/session_file.h"
#include "run_command.h"
#include "session/session_samples.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

const std::string kInfo = KESTREL_TOOL_DIR "/session_info ";

class SessionInfo : public ::testing::Test {
 protected:
  SessionInfo() { saveSession(file_, sampleSession(3, 720)); }

  /// Writes the file without its end.
  std::string cut() const {
    const std::string bytes = readFile(file_);
    return folder_.write("cut.session", bytes.substr(0, bytes.size() - 1000));
  }

  TemporaryFolder folder_;
  std::string file_ = folder_.file("a.session");
};

TEST_F(SessionInfo, PrintsWhatIsInTheFile) {
  const Outcome outcome = runCommand(kInfo + file_ + " --check");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_CONTAINS(outcome.output, "session in format 1, written by kestrel_slam test");
  EXPECT_CONTAINS(outcome.output, "keyframes    9\n");
  EXPECT_CONTAINS(outcome.output, "2014-05-13 16:53:30 UTC");
  EXPECT_CONTAINS(outcome.output, "submaps      3, 2 finished\n");
  EXPECT_CONTAINS(outcome.output, "loops        2 tried, 1 accepted, 1 refused\n");
  EXPECT_CONTAINS(outcome.output, "refused: 1 × two explanations");
  EXPECT_CONTAINS(outcome.output, "distance_m   12.5\n");
  EXPECT_CONTAINS(outcome.output, " KEYF ");
  EXPECT_CONTAINS(outcome.output, "the file is whole");
}

TEST_F(SessionInfo, SaysThatPartsOfTheGraphAreNotJoined) {
  Session session = sampleSession(5);
  session.edges.erase(session.edges.begin() + 1);
  const std::string file = folder_.file("parts.session");
  saveSession(file, session);
  EXPECT_CONTAINS(runCommand(kInfo + file).output,
                  "parts        2 that no loop joins; the map is the largest, with 9 keyframes\n");
}

TEST_F(SessionInfo, ExportsGraphPosesAndMap) {
  const std::string g2o = folder_.file("a.g2o"), tum = folder_.file("a.tum");
  const Outcome outcome = runCommand(kInfo + file_ + " --export-g2o " + g2o + " --export-tum " +
                                     tum + " --export-pgm " + folder_.file("maps/new"));
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  const PoseGraph graph = readG2o(g2o).graph;
  EXPECT_EQ(graph.vertices.size(), 3U);
  ASSERT_EQ(graph.edges.size(), 2U);
  EXPECT_EQ(graph.edges[1].information, sampleMatrix(1e4));
  const Trajectory poses = readTum(tum);
  ASSERT_EQ(poses.size(), 9U);
  EXPECT_NEAR(poses[1].pose.x, 0.1, 1e-6);
  EXPECT_NEAR(poses[1].stamp, 1.4e9 + 10.1, 1e-6);
  const MapSnapshot map = readMap(folder_.file("maps/new/map.yaml"));
  EXPECT_NEAR(map.width * map.resolution_m, 8.0, 0.3);
}

TEST_F(SessionInfo, RefusesDamagedFilesAndRepairsThem) {
  const std::string damaged = cut(), repaired = folder_.file("repaired.session");
  const Outcome outcome = runCommand(kInfo + damaged);
  EXPECT_EQ(outcome.code, 1);
  EXPECT_CONTAINS(outcome.output,
                  "session_info: " + damaged + ": the session is damaged: chunk 4 ");
  EXPECT_EQ(runCommand(kInfo + damaged + " --check").code, 1);
  const Outcome repair = runCommand(kInfo + damaged + " --repair " + repaired);
  EXPECT_EQ(repair.code, 0);
  EXPECT_CONTAINS(repair.output, "damaged: it has 0 of 9 keyframes");
  const Outcome again = runCommand(kInfo + repaired + " --check");
  EXPECT_EQ(again.code, 0);
  EXPECT_CONTAINS(again.output, "submaps      3");
  EXPECT_EQ(runCommand(kInfo + damaged + " --repair " + damaged).code, 2);
}

TEST_F(SessionInfo, SaysWhatIsNoSession) {
  const std::string picture = folder_.write("map.pgm", "P5\n1 1\n255\n.");
  for (const std::string& wrong : {picture, folder_.file(""), folder_.file("absent")}) {
    const Outcome outcome = runCommand(kInfo + wrong);
    EXPECT_EQ(outcome.code, 1);
    EXPECT_CONTAINS(outcome.output, wrong);
  }
}

}  // namespace
}  // namespace kestrel
