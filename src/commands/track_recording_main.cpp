// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "kestrel_slam/commands/mapping_command.h"
#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/evaluation/track_file.h"
#include "kestrel_slam/report/tracks_page.h"
#include "kestrel_slam/tracking/continuous_pose.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  MappingArguments mapping;
  std::string output;
};

void printSummary(const fs::path& folder, const std::vector<TrackFrame>& frames) {
  std::set<long> all, shown;
  std::size_t saturated = 0;
  for (const TrackFrame& frame : frames) {
    if (frame.saturated) ++saturated;
    for (const Track& track : frame.tracks) {
      all.insert(track.id);
      if (track.isShown()) shown.insert(track.id);
    }
  }
  std::printf("%-12s%zu objects that moved; %zu others stood or were seen too shortly\n", "tracks",
              shown.size(), all.size() - shown.size());
  if (saturated > 0) {
    std::printf("%-12s%zu of %zu scans had more objects than the tracker handles\n", "saturated",
                saturated, frames.size());
  }
  std::printf("%-12s%s\n", "paths", (folder / "tracks.csv").string().c_str());
  std::printf("%-12s%s\n", "page", (folder / "tracks.html").string().c_str());
}

void run(Arguments& arguments) {
  MappingArguments& mapping = arguments.mapping;
  const SlamConfig config = configOf(mapping);
  stopOnSignals();
  const auto recording = openFor(mapping);
  const RunInfo info = runInfoOf(mapping, config, *recording);
  const fs::path folder =
      arguments.output.empty() ? nameOf(mapping.recording()) + "_tracks" : arguments.output;
  prepareOutput(folder);
  Tracker tracker;
  ContinuousPose continuous;
  Trajectory path;
  std::vector<TrackFrame> frames;
  mapping.run.sweep_observer = [&](const MappedSweep& sweep) {
    if (sweep.moving != nullptr) {
      if (!sweep.moving->result().used) return;
      path.push_back({sweep.scan.stamp, sweep.moving->pose()});
      const Tracker::Result& kept_out = sweep.moving->result();
      frames.push_back({sweep.scan.stamp, kept_out.tracks, kept_out.saturated});
      return;
    }
    const bool may_jump = sweep.result.searched || sweep.result.state == MatchState::kLost;
    const Pose2 pose =
        continuous.add(sweep.scan.time, sweep.result.pose, may_jump, sweep.input.odom_T_base);
    const Tracker::Result& tracked = tracker.process(sweep.scan, pose);
    if (!tracked.used) return;
    path.push_back({sweep.scan.stamp, pose});
    frames.push_back({sweep.scan.stamp, tracked.tracks, tracked.saturated});
  };
  const OfflineRun run = mapWithProgress(*recording, config, mapping);
  const std::string page = tracksHtml({info.recording, run.map, run.trajectory, path, frames});
  writeOutputs(folder, run, info,
               {{"tracks.csv", tracksCsv(frames)},
                {"tracks.html", page},
                {"tracks.json", tracksJson(frames)},
                {"odom_trajectory.tum", tumText(path)}});
  printWarnings("warning: ", run);
  if (!mapping.quiet) printSummary(folder, frames);
}

void check(const Arguments& arguments) {
  if (arguments.mapping.recordings.empty()) throw CLI::RequiredError("RECORDING");
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app(
      "Maps a recording of a 2D laser and tracks what moves. Writes the files of map_recording, "
      "and "
      "tracks.csv, tracks.json and tracks.html.");
  Arguments arguments;
  app.add_option("--output", arguments.output, "output folder (default: ./<name>_tracks)");
  addMappingOptions(app, arguments.mapping);
  return runTool(
      "track_recording", app, argc, argv, [&] { run(arguments); }, [&] { check(arguments); });
}
