// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/session/session_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <limits>
#include <random>
#include <stdexcept>

#include "kestrel_slam/map/atomic_file.h"
#include "map/killed_writer.h"
#include "session/session_samples.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

TEST(SessionFile, GivesBackEverything) {
  const Session session = sampleSession();
  const Session loaded = decodeSession(encodeSession(session));
  EXPECT_EQ(loaded.written_by, session.written_by);
  EXPECT_EQ(loaded.resolution_m, session.resolution_m);
  EXPECT_EQ(loaded.parameters, session.parameters);
  ASSERT_EQ(loaded.statistics.size(), 2U);
  EXPECT_EQ(loaded.statistics[1].name, "distance_m");
  EXPECT_EQ(loaded.statistics[1].value, 12.5);
  EXPECT_EQ(loaded.end, session.end);
  ASSERT_EQ(loaded.keyframes.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    const Keyframe &a = *loaded.keyframes[i], &b = *session.keyframes[i];
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.stamp, b.stamp);
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.submap_T_base, b.submap_T_base);
    EXPECT_EQ(a.covariance, b.covariance);
    EXPECT_EQ(a.motion_covariance, b.motion_covariance);
    EXPECT_EQ(a.new_view, b.new_view);
    EXPECT_EQ(a.scan, b.scan);
  }
}

TEST(SessionFile, GivesBackSubmapsAndGraph) {
  const Session session = sampleSession();
  const Session loaded = decodeSession(encodeSession(session));
  ASSERT_EQ(loaded.submaps.size(), 2U);
  EXPECT_EQ(loaded.submaps[1].id, 11U);
  EXPECT_EQ(loaded.submaps[1].map_T_submap, session.submaps[1].map_T_submap);
  EXPECT_TRUE(loaded.submaps[0].finished);
  EXPECT_FALSE(loaded.submaps[1].finished);
  EXPECT_EQ(loaded.submaps[1].keyframes, session.submaps[1].keyframes);
  ASSERT_EQ(loaded.vertices.size(), 2U);
  EXPECT_EQ(loaded.vertices[0].kind, VertexKind::kSubmap);
  EXPECT_EQ(loaded.vertices[1].id, 11U);
  EXPECT_TRUE(loaded.vertices[0].vertex.fixed);
  EXPECT_EQ(loaded.vertices[1].vertex.pose, session.vertices[1].vertex.pose);
  ASSERT_EQ(loaded.edges.size(), 1U);
  EXPECT_EQ(loaded.edges[0].information, session.edges[0].information);
  EXPECT_EQ(loaded.edges[0].measured, session.edges[0].measured);
  ASSERT_EQ(loaded.loops.size(), 1U);
  EXPECT_EQ(loaded.loops[0].from, 1U);
  EXPECT_EQ(loaded.loops[0].state, LoopState::kRefused);
  EXPECT_EQ(loaded.loops[0].reason, "two explanations");
  EXPECT_EQ(loaded.loops[0].measured.covariance, session.loops[0].measured.covariance);
  EXPECT_EQ(loaded.loops[0].measures[0].value, 0.8);
}

TEST(SessionFile, TheSameSessionGivesTheSameBytes) {
  for (const std::size_t submaps : {0U, 1U, 2U, 1200U}) {
    const std::string bytes = encodeSession(sampleSession(submaps));
    EXPECT_TRUE(encodeSession(sampleSession(submaps)) == bytes);
    EXPECT_TRUE(encodeSession(decodeSession(bytes)) == bytes);
  }
}

TEST(SessionFile, DividesLargeSessionsIntoManyChunks) {
  const std::string bytes = encodeSession(sampleSession(1200));
  const ChunkReader reader(bytes);
  EXPECT_GT(reader.chunks().size(), 8U);
  for (const Chunk& chunk : reader.chunks()) EXPECT_LT(chunk.content_bytes, 300000U);
}

TEST(SessionFile, FindsEveryFlippedByte) {
  const std::string bytes = encodeSession(sampleSession(1, 20));
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x55);
    EXPECT_THROW(decodeSession(damaged), std::runtime_error) << i;
  }
}

TEST(SessionFile, FindsTruncationAtEveryChunk) {
  const std::string bytes = encodeSession(sampleSession(1200));
  const ChunkReader reader(bytes);
  for (const Chunk& chunk : reader.chunks()) {
    for (const std::uint64_t length : {chunk.offset - 1, chunk.offset, chunk.offset + 1}) {
      const std::string cut = bytes.substr(0, length);
      EXPECT_THROW(decodeSession(cut), std::runtime_error) << length;
      if (chunk.offset == reader.chunks()[0].offset && length < chunk.offset) continue;
      EXPECT_FALSE(repairSession(cut).damage.empty());
    }
  }
}

TEST(SessionFile, RepairKeepsEverythingBeforeTheDamage) {
  const Session session = sampleSession(1200);
  const std::string bytes = encodeSession(session);
  const Chunk last = ChunkReader(bytes).chunks().back();
  const RepairedSession repaired = repairSession(bytes.substr(0, last.offset + 100));
  EXPECT_CONTAINS(repaired.damage[0], "(KEYF) at byte " + std::to_string(last.offset));
  EXPECT_CONTAINS(repaired.damage[1], " of 3600 keyframes");
  EXPECT_GT(repaired.session.keyframes.size(), 2000U);
  EXPECT_LT(repaired.session.keyframes.size(), 3600U);
  EXPECT_EQ(repaired.session.submaps.size(), 1200U);
  EXPECT_EQ(repaired.session.edges.size(), 1199U);
  EXPECT_EQ(repaired.session.parameters, session.parameters);
  EXPECT_EQ(problemOf(repaired.session), "");
  const std::string again = encodeSession(repaired.session);
  EXPECT_EQ(decodeSession(again).keyframes.size(), repaired.session.keyframes.size());
}

/// Repairs the session after one byte of its n-th chunk with this tag has changed.
RepairedSession repairedWithout(const std::string& tag, std::size_t n) {
  std::string bytes = encodeSession(sampleSession(4000, 20));
  const ChunkReader reader(bytes);
  for (const Chunk& chunk : reader.chunks()) {
    if (chunk.tag != tag || n-- > 0) continue;
    bytes[chunk.offset + 40] = static_cast<char>(bytes[chunk.offset + 40] ^ 1);
    break;
  }
  return repairSession(bytes);
}

TEST(SessionFile, RepairLosesOnlyOneChunkWhereTheNextOnesAreWhole) {
  const RepairedSession keyframes = repairedWithout("KEYF", 1);
  EXPECT_GT(keyframes.session.keyframes.size(), 9000U);
  EXPECT_EQ(keyframes.session.edges.size(), 3999U);
  const RepairedSession info = repairedWithout("INFO", 0);
  EXPECT_EQ(info.session.keyframes.size(), 12000U);
  EXPECT_CONTAINS(info.damage.back(), "parameters");
}

TEST(SessionFile, RepairNeverConnectsTheWrongVertices) {
  const Session whole = sampleSession(4000, 20);
  const RepairedSession repaired = repairedWithout("GRAP", 0);
  EXPECT_TRUE(repaired.session.vertices.empty());
  EXPECT_TRUE(repaired.session.edges.empty());
  EXPECT_EQ(keyframePoses(repaired.session), keyframePoses(whole)) << "from the submaps";
  const RepairedSession submaps = repairedWithout("SUBM", 0);
  EXPECT_LT(submaps.session.vertices.size(), 4000U);
  for (const PoseEdge& edge : submaps.session.edges) {
    EXPECT_EQ(submaps.session.vertices[edge.from].id + 1, submaps.session.vertices[edge.to].id);
  }
}

TEST(SessionFile, SkipsUnknownChunksAndRefusesNewerOnes) {
  const std::string bytes = encodeSession(sampleSession(1));
  const ChunkReader reader(bytes);
  const auto rewritten = [&](std::uint32_t info_version) {
    ChunkWriter writer("kestrel_slam 9.0");
    writer.add("GRID", 7, "a cache");
    for (const Chunk& chunk : reader.chunks()) {
      writer.add(chunk.tag, chunk.tag == "INFO" ? info_version : 1, reader.content(chunk));
    }
    return writer.finish();
  };
  EXPECT_EQ(decodeSession(rewritten(1)).keyframes.size(), 3U);
  EXPECT_CONTAINS(messageOf([&] { decodeSession(rewritten(2)); }),
                  "the newer schema version 2; read the file with kestrel_slam 9.0");
  EXPECT_CONTAINS(messageOf([&] { repairSession(rewritten(2)); }), "newer schema version 2");
}

TEST(SessionFile, RefusesChunksWithWrongContents) {
  const std::string bytes = encodeSession(sampleSession(1));
  const ChunkReader reader(bytes);
  for (const Chunk& replaced : reader.chunks()) {
    ChunkWriter writer("test");
    for (const Chunk& chunk : reader.chunks()) {
      writer.add(chunk.tag, 1, chunk.tag == replaced.tag ? "\xFF no" : reader.content(chunk));
    }
    const std::string wrong = writer.finish();
    EXPECT_CONTAINS(messageOf([&] { decodeSession(wrong); }), "(" + replaced.tag + ") at byte ")
        << replaced.tag;
    EXPECT_FALSE(repairSession(wrong).damage.empty());
  }
}

TEST(SessionFile, DoesNotSaveWhatCouldNotBeLoaded) {
  const auto reasonOf = [](const Session& session) -> std::string {
    try {
      encodeSession(session);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  Session session = sampleSession();
  session.edges[0].to = 9;
  EXPECT_EQ(reasonOf(session),
            "the session cannot be saved: edge 0: one of its vertices does not exist");
  session = sampleSession();
  session.submaps[1].map_T_submap.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(reasonOf(session), "the session cannot be saved: submap 1: the pose is not finite");
  session = sampleSession();
  session.keyframes.push_back(session.keyframes[0]);
  EXPECT_CONTAINS(reasonOf(session), "two keyframes have the same id");
  session = sampleSession();
  session.submaps[0].keyframes.pop_back();
  EXPECT_CONTAINS(reasonOf(session), "keyframe 2: it is in no submap and in no vertex");
  session = sampleSession();
  session.vertices[1].id = 99;
  EXPECT_CONTAINS(reasonOf(session), "vertex 1: its keyframe or submap does not exist");
  session = sampleSession();
  session.loops[0].measured.covariance(0, 1) = 1.0;
  EXPECT_CONTAINS(reasonOf(session), "loop 0: a covariance is not symmetric");
}

TEST(SessionFile, NamesTheFileThatCannotBeLoaded) {
  const TemporaryFolder folder;
  EXPECT_CONTAINS(messageOf([&] { loadSession(folder.file("absent.session")); }),
                  "cannot read " + folder.file("absent.session"));
  EXPECT_CONTAINS(messageOf([&] { loadSession(folder.file("")); }), "cannot read ");
  const std::string picture = folder.write("map.pgm", "P5\n1 1\n255\n.");
  EXPECT_EQ(messageOf([&] { loadSession(picture); }),
            "cannot read " + picture + ": it is not a session of kestrel_slam");
  EXPECT_FALSE(isSessionFile(picture));
  EXPECT_FALSE(isSessionFile(folder.file("")));
  saveSession(folder.file("a.session"), sampleSession(1));
  EXPECT_TRUE(isSessionFile(folder.file("a.session")));
  std::string bytes = readFile(folder.file("a.session"));
  bytes.pop_back();
  const std::string cut = folder.write("cut.session", bytes);
  EXPECT_CONTAINS(messageOf([&] { loadSession(cut); }),
                  "cannot load " + cut + ": the session is damaged: its end at byte ");
}

TEST(SessionFile, AKilledWriterLeavesTheOldOrTheNewFile) {
  const TemporaryFolder folder;
  const std::string path = folder.file("a.session");
  const Session one = sampleSession(30), other = sampleSession(31);
  saveSession(path, one);
  killWhileWriting(
      20, [&](int n) { saveSession(path, n % 2 == 0 ? one : other); },
      [&] {
        const std::size_t submaps = loadSession(path).submaps.size();
        EXPECT_TRUE(submaps == 30U || submaps == 31U);
      });
  saveSession(path, one);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.file("")), fs::directory_iterator()), 1);
}

/// While it exists, no file can become longer than `bytes`, as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(SessionFile, WithoutRoomTheOldFileStays) {
  const TemporaryFolder folder;
  const std::string path = folder.file("a.session");
  saveSession(path, sampleSession(1));
  const std::string old = readFile(path);
  {
    const FullDisk full(old.size() + 1000);
    EXPECT_EQ(messageOf([&] { saveSession(path, sampleSession(300)); }),
              "cannot write " + path + ": File too large");
  }
  EXPECT_TRUE(readFile(path) == old);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.file("")), fs::directory_iterator()), 1);
}

TEST(SessionFile, AnOldFileOfEveryVersionCanBeRead) {
  const std::string path = KESTREL_SOURCE_DIR "/test/session/golden/version_1.session";
  const Session session = loadSession(path);
  EXPECT_EQ(session.written_by, "kestrel_slam 0.2.0");
  Session expected = sampleSession();
  expected.written_by = session.written_by;
  ASSERT_EQ(session.keyframes.size(), expected.keyframes.size());
  for (std::size_t i = 0; i < session.keyframes.size(); ++i) {
    EXPECT_EQ(session.keyframes[i]->scan, expected.keyframes[i]->scan);
    EXPECT_FALSE(session.keyframes[i]->height.isKnown());
  }
  EXPECT_EQ(decodeSession(encodeSession(expected)).loops[0].reason, session.loops[0].reason);
  EXPECT_EQ(session.parameters, expected.parameters);
  EXPECT_EQ(session.edges[0].information, expected.edges[0].information);
}

/// The first file with heights, of the same version: older programs read it, without the heights.
TEST(SessionFile, HeightsAreKept) {
  Session expected = sampleSession();
  expected.keyframes[1] = atHeight(*expected.keyframes[1], {1.25F, {0.125F, -0.25F}});
  const std::string golden = KESTREL_SOURCE_DIR "/test/session/golden/version_1_heights.session";
  for (const Session& session : {decodeSession(encodeSession(expected)), loadSession(golden)}) {
    ASSERT_EQ(session.keyframes.size(), expected.keyframes.size());
    EXPECT_EQ(session.keyframes[1]->height.base_m, 1.25F);
    EXPECT_EQ(session.keyframes[1]->height.slope, Eigen::Vector2f(0.125F, -0.25F));
    EXPECT_FALSE(session.keyframes[0]->height.isKnown());
    EXPECT_EQ(session.keyframes[1]->scan, expected.keyframes[1]->scan);
  }
}

TEST(SessionFile, AHeightThatIsNotKnownNeedsNoBytes) {
  constexpr std::size_t kThreeNumbers = 15;
  Session session = sampleSession();
  const std::size_t bytes = encodeSession(session).size();
  session.keyframes[1] = atHeight(*session.keyframes[1], {1.25F, {0.125F, -0.25F}});
  EXPECT_GE(encodeSession(session).size(), bytes + kThreeNumbers);
}

}  // namespace
}  // namespace kestrel
