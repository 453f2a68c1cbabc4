#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/map/map_io.h"
#include "kestrel_slam/tools/claims.h"
#include "kestrel_slam/tools/offline_run.h"
#include "kestrel_slam/tools/parameters_yaml.h"
#include "kestrel_slam/tools/progress_bar.h"
#include "kestrel_slam/tools/report.h"
#include "kestrel_slam/tools/stats.h"
#include "kestrel_slam/tools/version.h"

namespace kestrel_slam {
namespace {

namespace fs = std::filesystem;

constexpr int kSuccess = 0, kBadInput = 1, kWrongUsage = 2;
constexpr int kJsonIndent = 2;

volatile std::sig_atomic_t stop_requested = 0;

void requestStop(int /*signal*/) { stop_requested = 1; }

struct Arguments {
  std::string recording;
  std::string output;
  std::string config;
  std::string odometry = "none";
  std::string imu = "use";
  std::vector<std::string> settings;
  RecordingOptions topics;
  bool no_timing = false;
  bool quiet = false;
  bool list_parameters = false;
  bool version = false;
};

void declareOptions(CLI::App& app, Arguments& arguments) {
  app.add_option(
      "RECORDING", arguments.recording,
      "rosbag, CARMEN log, BreezySLAM log or table of ranges (logs plain, .bz2, .gz or .xz)");
  app.add_option("--output", arguments.output,
                 "folder for map, trajectory, statistics and report (default: ./<name>_map)");
  app.add_option("--config", arguments.config, "YAML file with parameters");
  app.add_option("--odometry", arguments.odometry,
                 "none: laser only (default); use: predict from the recording's odometry")
      ->check(CLI::IsMember({"none", "use"}));
  app.add_option("--imu", arguments.imu,
                 "use: roll, pitch and turn rate from the recording's IMU (default); none: level")
      ->check(CLI::IsMember({"none", "use"}));
  app.add_option("--set", arguments.settings, "name=value: a parameter, after those of --config")
      ->expected(1)
      ->take_all();
  app.add_option("--scan-topic", arguments.topics.scan_topic,
                 "bags: which laser, or clouds of a 3D lidar");
  app.add_option("--odom-topic", arguments.topics.odom_topic, "bags: which odometry");
  app.add_option("--imu-topic", arguments.topics.imu_topic, "bags: which IMU");
  app.add_option("--height-topic", arguments.topics.height_topic,
                 "bags: which range finder measures the height");
  app.add_option("--base-frame", arguments.topics.base_frame, "bags: the frame of the vehicle");
  app.add_option("--rate", arguments.topics.rate_hz, "tables of ranges: scans a second")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("--no-timing", arguments.no_timing,
               "leave measured times and memory out of the files: two runs give the same bytes");
  app.add_flag("--quiet", arguments.quiet, "only warnings and errors");
  app.add_flag("--list-parameters", arguments.list_parameters,
               "print all parameters with their defaults as YAML, and stop");
  app.add_flag("--version", arguments.version, "print the version, and stop");
}

/// The file's name without its folder and without the endings of recordings.
std::string nameOf(const std::string& recording) {
  fs::path name = fs::path(recording).filename();
  for (const char* ending : {".bz2", ".gz", ".xz", ".bag", ".clf", ".log", ".csv", ".dat"}) {
    if (name.extension() == ending && name != ending) name = name.stem();
  }
  return name.string();
}

SlamConfig configOf(const Arguments& arguments) {
  SlamConfig config;
  if (!arguments.config.empty()) loadParameters(arguments.config, config);
  for (const std::string& setting : arguments.settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) {
      throw std::invalid_argument("--set " + setting + ": must be name=value");
    }
    setParameter(config, setting.substr(0, equals), setting.substr(equals + 1));
  }
  validate(config);
  return config;
}

/// Makes the folder and tries to write into it, so that a long run is not lost at its end.
void prepareOutput(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error)) {
    throw std::runtime_error("cannot write to " + folder.string() +
                             ": it is a file, not a folder; choose another --output");
  }
  fs::create_directories(folder, error);
  if (error) {
    throw std::runtime_error("cannot make the output folder " + folder.string() + ": " +
                             error.message() + "; choose another --output");
  }
  const fs::path probe = folder / ".kestrel_slam_probe";
  writeFileAtomically(probe.string(), "");
  fs::remove(probe, error);
}

OfflineRun mapIt(Recording& recording, const RunInfo& info, const RunOptions& options, bool quiet) {
  ProgressBar bar(stderr, ::isatty(STDERR_FILENO) == 1);
  const OfflineRun run =
      runOffline(recording, info.config, options, [&](const OfflineProgress& progress) {
        if (!quiet) bar.update(progress);
        return stop_requested == 0;
      });
  if (!quiet) bar.finish();
  return run;
}

void writeOutputs(const fs::path& folder, const OfflineRun& run, const RunInfo& info) {
  writeMap((folder / "map").string(), run.map);
  writeTum((folder / "trajectory.tum").string(), run.trajectory);
  std::vector<Claim> claims;
  claims.reserve(run.scans.size());
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    claims.push_back({run.trajectory[i].stamp, run.scans[i].uncertain});
  }
  writeClaims((folder / "covariances.txt").string(), claims);
  writeFileAtomically(
      (folder / "stats.json").string(),
      statsOf(run, info).dump(kJsonIndent, ' ', false, nlohmann::json::error_handler_t::replace) +
          "\n");
  writeFileAtomically((folder / "report.html").string(), reportHtml(run, info));
}

void printSummary(const fs::path& folder, const OfflineRun& run) {
  const std::size_t scans = run.scans.size();
  const MatchSummary match = summarize(run.scans);
  std::printf("%-12s%zu processed, %zu dropped, %zu lost\n", "scans", scans, run.droppedCount(),
              match.lost);
  std::printf("%-12s%.1f m in %.0f s\n", "distance", run.distance_m, run.duration_s);
  std::printf("%-12s%.3f ms a scan, %.0f x real time, %.0f MB\n", "time", scanTimes(run).mean,
              run.speedFactor(), run.peak_memory_mb);
  for (const auto& [what, file] : {std::pair{"map", "map.yaml"},
                                   {"trajectory", "trajectory.tum"},
                                   {"covariances", "covariances.txt"},
                                   {"statistics", "stats.json"},
                                   {"report", "report.html"}}) {
    std::printf("%-12s%s\n", what, (folder / file).string().c_str());
  }
}

/// A run without a single pose has nothing to write; its warnings say why.
[[noreturn]] void refuseEmpty(const std::string& recording, const OfflineRun& run) {
  const std::string why = run.warnings.empty() ? "it has no scans" : run.warnings.front();
  throw std::runtime_error(recording + ": no scan could be used: " + why);
}

void mapRecording(const Arguments& arguments) {
  RunInfo info;
  info.config = configOf(arguments);
  info.odometry = arguments.odometry == "use";
  info.timing = !arguments.no_timing;
  info.recording = fs::path(arguments.recording).filename().string();
  const auto recording = openRecording(arguments.recording, arguments.topics);
  if (info.odometry && !recording->hasOdometry()) {
    throw std::runtime_error(arguments.recording + ": has no odometry; use --odometry none");
  }
  info.description = recording->description();
  const fs::path folder =
      arguments.output.empty() ? nameOf(arguments.recording) + "_map" : arguments.output;
  std::signal(SIGINT, requestStop);
  std::signal(SIGTERM, requestStop);
  prepareOutput(folder);

  const OfflineRun run =
      mapIt(*recording, info, {info.odometry, arguments.imu == "use"}, arguments.quiet);
  if (run.scans.empty()) refuseEmpty(arguments.recording, run);
  writeOutputs(folder, run, info);
  for (const std::string& warning : run.warnings) {
    std::fprintf(stderr, "warning: %s\n", warning.c_str());
  }
  if (!arguments.quiet) printSummary(folder, run);
}

int runTool(int argc, char** argv) {
  CLI::App app("Maps a recording of a 2D laser and writes the map, the trajectory and a report.");
  Arguments arguments;
  declareOptions(app, arguments);
  try {
    app.parse(argc, argv);
    if (arguments.recording.empty() && !arguments.list_parameters && !arguments.version) {
      throw CLI::RequiredError("RECORDING");
    }
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kSuccess : kWrongUsage;
  }
  if (arguments.version) {
    std::puts(kVersion);
    return kSuccess;
  }
  if (arguments.list_parameters) {
    std::fputs(defaultParametersYaml().c_str(), stdout);
    return kSuccess;
  }
  mapRecording(arguments);
  return kSuccess;
}

}  // namespace
}  // namespace kestrel_slam

int main(int argc, char** argv) {
  try {
    return kestrel_slam::runTool(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "map_recording: %s\n", error.what());
    return kestrel_slam::kBadInput;
  }
}
