// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/session_measurement.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <random>
#include <stdexcept>

#include "kestrel_slam/graph/composed_map.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/session/graph_session.h"
#include "kestrel_slam/session/session_file.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Reads the session until it could go on, and returns the time.
double timeToLoad(const std::string& file, const SlamConfig& config) {
  const Clock::time_point start = Clock::now();
  const SubmapGraph graph(config.mapper, config.loops,
                          graphRecordOf(loadSession(file), config.mapper.grid.resolution_m));
  ComposedMap map(config.mapper.grid);
  map.add(graph);
  return secondsSince(start);
}

double largestMotion(const std::vector<Pose2>& before, const std::vector<Pose2>& after) {
  double largest = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Pose2 moved =
        before.front().between(before[i]).inverse() * after.front().between(after[i]);
    largest = std::max(largest, moved.distance());
  }
  return largest;
}

Session mapAgain(const std::string& recording, const SlamConfig& config,
                 const std::shared_ptr<const Session>& before, int number) {
  RunOptions options;
  options.session = before;
  if (before) options.start = givenStart(keyframePoses(*before).front());
  options.perturbation.drop_beams_share = 0.1;
  options.perturbation.beams_seed = static_cast<std::uint64_t>(number) + 1;
  const auto source = openRecording({recording}, {});
  OfflineRun run = runOffline(*source, config, options);
  if (!run.session) throw std::runtime_error(recording + ": no scan could be used");
  return std::move(*run.session);
}

bool isJoined(const Session& session) {
  const std::vector<std::size_t> parts = connectedParts(graphOf(session));
  return std::all_of(parts.begin(), parts.end(), [](std::size_t part) { return part == 0; });
}

/// What is wrong with the folder after a kill; "" if nothing is.
std::string problemIn(const std::string& folder, const std::string& file) {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().string() != file) return "left over: " + entry.path().filename().string();
  }
  try {
    loadSession(file);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

[[noreturn]] void saveForever(const std::string& file, const Session& session) {
  for (;;) {
    try {
      saveSession(file, session);
    } catch (const std::exception&) {
      _exit(1);
    }
  }
}

bool sameContent(const Session& session, const std::string& bytes) {
  return encodeSession(session) == bytes;
}

void tryBytes(const std::string& damaged, const std::string& bytes, DamageCounts& counts) {
  ++counts.tried;
  try {
    ++(sameContent(decodeSession(damaged), bytes) ? counts.same : counts.different);
  } catch (const std::runtime_error&) {
    ++counts.refused;
  }
}

}  // namespace

std::vector<FlightOfSession> measureFlights(const std::string& recording, const SlamConfig& config,
                                            int flights, const std::string& file) {
  std::vector<FlightOfSession> result;
  std::shared_ptr<const Session> session;
  std::vector<Pose2> first;
  for (int number = 0; number < flights; ++number) {
    session = std::make_shared<const Session>(mapAgain(recording, config, session, number));
    const std::vector<Pose2> poses = keyframePoses(*session);
    if (number == 0) first = poses;
    FlightOfSession flight;
    flight.keyframes = poses.size();
    flight.joined = isJoined(*session);
    flight.drift_m = largestMotion(first, poses);
    const Clock::time_point start = Clock::now();
    saveSession(file, *session);
    flight.save_s = secondsSince(start);
    flight.megabytes = 1e-6 * static_cast<double>(fs::file_size(file));
    flight.load_s = timeToLoad(file, config);
    result.push_back(flight);
  }
  return result;
}

std::vector<std::string> measureKills(const std::string& folder, const Session& session,
                                      int kills) {
  const std::string file = (fs::path(folder) / "a.session").string();
  const Clock::time_point begin = Clock::now();
  saveSession(file, session);
  const double save_s = secondsSince(begin);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> wait(0.0, 3.0 * save_s);
  std::vector<std::string> problems;
  for (int i = 0; i < kills; ++i) {
    const pid_t child = fork();
    if (child < 0) throw std::runtime_error("cannot start a process");
    if (child == 0) saveForever(file, session);
    usleep(static_cast<useconds_t>(1e6 * wait(random)));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    const std::string problem = problemIn(folder, file);
    if (!problem.empty()) problems.push_back(problem);
  }
  return problems;
}

DamageCounts measureDamage(const std::string& bytes, std::size_t flips) {
  DamageCounts counts;
  std::mt19937 random(1);
  for (std::size_t i = 0; i < flips; ++i) {
    std::string damaged = bytes;
    damaged[i * bytes.size() / flips] ^= static_cast<char>(1U << random() % 8U);
    tryBytes(damaged, bytes, counts);
  }
  const ChunkReader file(bytes);
  for (const Chunk& chunk : file.chunks()) {
    for (const std::uint64_t at : {chunk.offset - 1, chunk.offset, chunk.offset + 1})
      tryBytes(bytes.substr(0, at), bytes, counts);
  }
  tryBytes(bytes.substr(0, bytes.size() - 1), bytes, counts);
  return counts;
}

}  // namespace kestrel
