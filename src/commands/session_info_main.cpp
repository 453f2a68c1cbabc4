// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/graph/g2o_file.h"
#include "kestrel_slam/map/map_io.h"
#include "kestrel_slam/parameters/parameters_yaml.h"
#include "kestrel_slam/recording/trajectory.h"
#include "kestrel_slam/session/session_file.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string file, repair, g2o, tum, pgm;
  bool check = false;
};

void printChunks(const ChunkReader& file) {
  std::printf("%6s %5s %8s %12s %12s %12s\n", "chunk", "tag", "version", "at byte", "bytes",
              "unpacked");
  for (std::size_t i = 0; i < file.chunks().size(); ++i) {
    const Chunk& chunk = file.chunks()[i];
    std::printf("%6zu %5s %8u %12llu %12llu %12llu\n", i, chunk.tag.c_str(), chunk.schema_version,
                static_cast<unsigned long long>(chunk.offset),
                static_cast<unsigned long long>(chunk.packed_bytes),
                static_cast<unsigned long long>(chunk.content_bytes));
  }
}

void printDamage(const std::vector<std::string>& damage) {
  for (const std::string& line : damage) std::printf("damaged: %s\n", line.c_str());
}

/// "2026-11-26 09:17:00 UTC" if the stamp can be a date, else seconds.
std::string timeText(double stamp) {
  char text[40];
  constexpr double kFirstDate = 946684800.0;  // 2000-01-01
  constexpr double kLastDate = 4102444800.0;  // 2100-01-01
  const auto seconds = static_cast<std::time_t>(std::clamp(stamp, 0.0, kLastDate));
  if (stamp < kFirstDate || stamp >= kLastDate ||
      std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", std::gmtime(&seconds)) == 0) {
    std::snprintf(text, sizeof text, "%.3f s", stamp);
  }
  return text;
}

void printKeyframes(const Session& session) {
  std::printf("keyframes    %zu\n", session.keyframes.size());
  if (session.keyframes.empty()) return;
  double first = session.keyframes.front()->stamp, last = first;
  std::size_t rays = 0, bytes = 0;
  for (const KeyframePtr& keyframe : session.keyframes) {
    first = std::min(first, keyframe->stamp);
    last = std::max(last, keyframe->stamp);
    rays += keyframe->scan.rayCount();
    bytes += keyframe->memoryBytes();
  }
  const auto count = static_cast<double>(session.keyframes.size());
  std::printf("from         %s\nuntil        %s\n", timeText(first).c_str(),
              timeText(last).c_str());
  std::printf("rays         %.0f a keyframe; the keyframes need %.1f MB of memory\n",
              static_cast<double>(rays) / count, 1e-6 * static_cast<double>(bytes));
}

void printSubmaps(const Session& session) {
  const auto finished = std::count_if(session.submaps.begin(), session.submaps.end(),
                                      [](const SubmapRecord& submap) { return submap.finished; });
  std::printf("submaps      %zu, %zu finished\n", session.submaps.size(),
              static_cast<std::size_t>(finished));
}

void printGraph(const Session& session) {
  std::map<LoopState, std::size_t> states;
  std::map<std::string, std::size_t> refused;
  for (const LoopRecord& loop : session.loops) {
    ++states[loop.state];
    if (loop.state == LoopState::kRefused) ++refused[loop.reason];
  }
  std::printf("graph        %zu vertices, %zu edges\n", session.vertices.size(),
              session.edges.size());
  const std::size_t parts = partCount(session);
  if (parts > 1)
    std::printf("parts        %zu that no loop joins; the map is the largest, with %zu keyframes\n",
                parts, mapKeyframes(session).size());
  std::printf("loops        %zu tried", session.loops.size());
  for (const auto& [state, count] : states) std::printf(", %zu %s", count, toString(state));
  std::printf("\n");
  for (const auto& [reason, count] : refused) {
    std::printf("             refused: %zu × %s\n", count, reason.c_str());
  }
}

void printSession(const Options& options, const ChunkReader& file, const Session& session,
                  std::size_t bytes) {
  std::printf("%s: session in format %u, written by %s, %.2f MB\n", options.file.c_str(),
              file.containerVersion(), file.writer().c_str(), 1e-6 * static_cast<double>(bytes));
  printKeyframes(session);
  printSubmaps(session);
  printGraph(session);
  std::printf("cell size    %g m\n", session.resolution_m);
  if (session.end) {
    std::printf("ended at     x %.3f m, y %.3f m, yaw %.4f rad\n", session.end->x, session.end->y,
                session.end->yaw);
  }
  for (const NamedNumber& number : session.statistics) {
    std::printf("%-12s %.10g\n", number.name.c_str(), number.value);
  }
}

Trajectory trajectoryOf(const Session& session) {
  const std::vector<Pose2> poses = keyframePoses(session);
  Trajectory trajectory;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    trajectory.push_back({session.keyframes[i]->stamp, poses[i]});
  }
  return trajectory;
}

/// The parameters of the session. Those of another version may be unknown: then the defaults.
OccupancyGridConfig gridConfigOf(const Session& session) {
  SlamConfig config;
  try {
    takeParameters(session.parameters, "the parameters of the session", parametersOf(config));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "session_info: %s; the map is made with the defaults\n", error.what());
    config = SlamConfig();
  }
  config.mapper.grid.resolution_m = session.resolution_m;
  return config.mapper.grid;
}

void exportMap(const std::string& folder, const Session& session) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder, error)) {
    throw std::runtime_error("cannot create the folder " + folder + "; choose another one");
  }
  writeMap((fs::path(folder) / "map").string(), mapOf(session, gridConfigOf(session)));
}

void exportAll(const Options& options, const Session& session) {
  if (!options.g2o.empty()) writeG2o(options.g2o, {graphOf(session), {}});
  if (!options.tum.empty()) writeTum(options.tum, trajectoryOf(session));
  if (!options.pgm.empty()) exportMap(options.pgm, session);
}

Session readSession(const Options& options, const std::string& bytes) {
  if (options.repair.empty() && !options.check) return decodeSession(bytes);
  RepairedSession repaired = repairSession(bytes);
  printDamage(repaired.damage);
  if (!options.repair.empty()) {
    saveSession(options.repair, repaired.session);
  } else if (!repaired.damage.empty()) {
    throw std::runtime_error("the session is damaged; --repair OUT keeps the rest");
  }
  return std::move(repaired.session);
}

void run(const Options& options) {
  const std::string bytes = readSessionFile(options.file);
  try {
    const ChunkReader file(bytes);
    if (options.check) printChunks(file);
    const Session session = readSession(options, bytes);
    printSession(options, file, session, bytes.size());
    if (options.check) std::printf("checked      the file is whole\n");
    exportAll(options, session);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(options.file + ": " + error.what());
  }
}

void check(const Options& options) {
  std::error_code ignored;
  if (fs::equivalent(options.file, options.repair, ignored)) {
    throw CLI::ValidationError("--repair", "write to another file than the damaged one");
  }
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app(
      "Prints what a session file contains, and checks, repairs and exports it.\n"
      "Exit code 0: done; 1: bad input, or the file is damaged; 2: wrong usage.");
  Options options;
  app.add_option("FILE", options.file, "session file")->required();
  app.add_flag("--check", options.check, "also list the chunks and everything that is damaged");
  app.add_option("--repair", options.repair,
                 "OUT: write what is left of a damaged file to this file");
  app.add_option("--export-g2o", options.g2o, "FILE: write the pose graph in the format of g2o");
  app.add_option("--export-tum", options.tum,
                 "FILE: write the poses of the keyframes in the TUM format");
  app.add_option("--export-pgm", options.pgm,
                 "DIR: write the map as map.pgm and map.yaml to this folder");
  return runTool(
      "session_info", app, argc, argv, [&] { run(options); }, [&] { check(options); });
}
