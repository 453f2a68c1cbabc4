// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/experiments/session_measurement.h"
#include "kestrel_slam/session/session_file.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string recording;
  int flights = 10, kills = 200;
  std::size_t flips = 10000;
};

/// A folder that is removed at the end.
class Scratch {
 public:
  Scratch() {
    std::string name = (fs::temp_directory_path() / "kestrel_sessions_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot create " + name);
    path_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  fs::path path() const { return path_; }

 private:
  fs::path path_;
};

void printFlights(const std::vector<FlightOfSession>& flights) {
  std::printf(
      "| flight | keyframes | growth | joined | file | drift | saved | loaded and ready |\n"
      "|---|---|---|---|---|---|---|---|\n");
  double before = 0.0;
  for (std::size_t i = 0; i < flights.size(); ++i) {
    const FlightOfSession& flight = flights[i];
    const auto keyframes = static_cast<double>(flight.keyframes);
    std::printf("| %zu | %zu | %.1f %% | %s | %.2f MB | %.3f m | %.2f s | %.2f s |\n", i + 1,
                flight.keyframes, i == 0 ? 0.0 : 100.0 * (keyframes / before - 1.0),
                flight.joined ? "yes" : "no", flight.megabytes, flight.drift_m, flight.save_s,
                flight.load_s);
    before = keyframes;
  }
  std::fflush(stdout);
}

void printKills(const Scratch& scratch, const Session& session, int kills) {
  const fs::path folder = scratch.path() / "kills";
  fs::create_directory(folder);
  const std::vector<std::string> problems = measureKills(folder.string(), session, kills);
  std::printf("killed %d times while saving: %zu problems\n", kills, problems.size());
  for (const std::string& problem : problems) std::printf("  %s\n", problem.c_str());
  std::fflush(stdout);
}

void run(const Options& options) {
  SlamConfig config;
  config.mapper.window.enabled = true;
  const Scratch scratch;
  const std::string file = (scratch.path() / "flights.session").string();
  printFlights(measureFlights(options.recording, config, options.flights, file));
  const std::string bytes = readSessionFile(file);
  const Session session = decodeSession(bytes);
  std::printf("loaded and saved again: %s\n",
              encodeSession(session) == bytes ? "the same bytes" : "OTHER BYTES");
  if (options.kills > 0) printKills(scratch, session, options.kills);
  if (options.flips == 0) return;
  const DamageCounts damage = measureDamage(bytes, options.flips);
  std::printf("damaged %zu times: %zu refused, %zu the same content, %zu SILENTLY DIFFERENT\n",
              damage.tried, damage.refused, damage.same, damage.different);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app(
      "Maps a recording several times as one session and measures growth, file and times; kills "
      "the process while it saves, and damages the file.");
  Options options;
  app.add_option("RECORDING", options.recording, "recording with a laser")->required();
  app.add_option("--flights", options.flights, "number of flights")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--kills", options.kills, "number of times that the process is killed")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--flips", options.flips, "number of bytes that are changed, one at a time")
      ->capture_default_str();
  return runTool("measure_sessions", app, argc, argv, [&] { run(options); });
}
