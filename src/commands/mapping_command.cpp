// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/commands/mapping_command.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <set>
#include <stdexcept>

#include "kestrel_slam/evaluation/covariance_file.h"
#include "kestrel_slam/evaluation/scan_file.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/graph/g2o_file.h"
#include "kestrel_slam/map/map_folder.h"
#include "kestrel_slam/offline/provenance.h"
#include "kestrel_slam/parameters/parameters_yaml.h"
#include "kestrel_slam/recording/trajectory.h"
#include "kestrel_slam/report/map_image.h"
#include "kestrel_slam/report/progress_bar.h"
#include "kestrel_slam/report/report.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

constexpr int kJsonIndent = 2;
constexpr int kPoseNumbers = 3;  // x, y, yaw
constexpr int kThumbnailPixels = 320;

volatile std::sig_atomic_t stop_requested = 0;

/// A second signal ends the program at once.
void requestStop(int signal) {
  stop_requested = 1;
  std::signal(signal, SIG_DFL);
}

void addTopicOptions(CLI::App& app, RecordingOptions& topics) {
  app.add_option("--scan-topic", topics.scan_topic,
                 "bags: topic of the laser scans, or of the clouds of a 3D lidar");
  app.add_option("--odom-topic", topics.odom_topic, "bags: topic of the odometry");
  app.add_option("--imu-topic", topics.imu_topic, "bags: topic of the IMU");
  app.add_option("--height-topic", topics.height_topic,
                 "bags: topic of the range finder that measures the height");
  app.add_option("--base-frame", topics.base_frame, "bags: frame of the vehicle");
  app.add_option("--rate", topics.rate_hz,
                 "tables of ranges: scans per second, if the table has no stamps")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--fov", topics.fov_deg,
                 "tables of ranges: field of view in degrees, if the table has no angles")
      ->check(CLI::Range(1.0, 360.0));
}

ScanRow rowOf(const StampedPose& pose, const ScanRecord& scan) {
  ScanRow row;
  row.stamp = pose.stamp;
  row.pose = pose.pose;
  row.state = scan.state;
  row.score = scan.score;
  row.known = scan.known;
  row.constraint = scan.constraint;
  row.degenerate_direction = scan.degenerate_direction;
  row.sigmas = scan.uncertain.covariance().diagonal().cwiseMax(0.0).cwiseSqrt();
  row.inserted = scan.inserted;
  row.searched = scan.searched;
  row.carried = scan.carried;
  row.ambiguous = scan.ambiguous;
  row.reason = scan.reason;
  row.odom_T_base = scan.odom_T_base;
  return row;
}

void addRunOptions(CLI::App& app, RunOptions& run) {
  Perturbation& perturbation = run.perturbation;
  app.add_option("--scans", run.max_scans, "N: use only the first N scans")
      ->check(CLI::PositiveNumber);
  app.add_option("--skip-scans", perturbation.skip_scans, "N: skip the first N scans");
  app.add_option("--drop-every", perturbation.drop_every, "N: skip every N-th scan")
      ->check(CLI::PositiveNumber);
  app.add_option("--drop-beams", perturbation.drop_beams_share,
                 "fraction of the beams to ignore; they are chosen at random with a fixed seed")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--drop-beams-seed", perturbation.beams_seed, "seed of --drop-beams")
      ->capture_default_str();
  app.add_option("--odometry-error",
                 "errors added to the odometry, with commas between them: short:SHARE, "
                 "turn:RAD_PER_M, unsigned, slip:M (about every 30 m, with a fixed seed)")
      ->each([&perturbation](const std::string& text) {
        try {
          perturbation.odometry = parseOdometryError(text);
        } catch (const std::invalid_argument& error) {
          throw CLI::ValidationError("--odometry-error", error.what());
        }
      });
}

/// The options on the command line that change the result, except parameters.
std::vector<std::pair<std::string, std::string>> optionsOf(const CLI::App& app) {
  static const std::set<std::string> kOthers = {
      "RECORDING", "--config", "--set", "--output", "--quiet", "--no-timing", "--save-session"};
  std::vector<std::pair<std::string, std::string>> options;
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0 || kOthers.count(option->get_name()) > 0) continue;
    std::string values;
    for (const std::string& value : option->results()) {
      values += (values.empty() ? "" : ",") + value;
    }
    options.emplace_back(option->get_name(), values);
  }
  return options;
}

/// Advice for a recording whose IMU makes all scans unusable.
std::string imuAdvice(const OfflineRun& run) {
  static const std::set<std::string> kReasons = {"no-imu",
                                                 "imu-silent",
                                                 "imu-frozen",
                                                 "imu-invalid",
                                                 toString(AttitudeError::kEmpty),
                                                 toString(AttitudeError::kTooOld),
                                                 toString(AttitudeError::kNotYet),
                                                 toString(AttitudeError::kGap),
                                                 toString(ScanError::kTilted),
                                                 toString(ScanError::kNoAttitude)};
  const bool caused = std::any_of(run.dropped.begin(), run.dropped.end(), [](const auto& entry) {
    return kReasons.count(entry.first) > 0;
  });
  return caused ? "; --imu none maps without the IMU" : "";
}

/// A trajectory with ascending stamps.
Trajectory sortedTum(const std::string& path) {
  Trajectory trajectory = readTum(path);
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
  return trajectory;
}

}  // namespace

void addLaserPoseOption(CLI::App& app, std::vector<double>& x_y_yaw) {
  app.add_option("--laser-pose", x_y_yaw,
                 "x,y,yaw in m and degrees: mounting of the laser; replaces that of the recording")
      ->delimiter(',')
      ->expected(kPoseNumbers);
}

std::optional<Eigen::Isometry3d> laserPoseOf(const std::vector<double>& x_y_yaw) {
  if (x_y_yaw.empty()) return std::nullopt;
  Eigen::Isometry3d mounting(Eigen::Translation3d(x_y_yaw[0], x_y_yaw[1], 0.0));
  mounting.rotate(Eigen::AngleAxisd(degToRad(x_y_yaw[2]), Eigen::Vector3d::UnitZ()));
  return mounting;
}

void addMappingOptions(CLI::App& app, MappingArguments& arguments) {
  arguments.app = &app;
  app.add_option(
      "RECORDING", arguments.recordings,
      "rosbag, CARMEN log, BreezySLAM log or table of ranges (may be .bz2, .gz or .xz); of a "
      "recording that was split into several bags: all of them");
  app.add_option("--config", arguments.config, "YAML file with parameters");
  app.add_option("--odometry", arguments.odometry,
                 "none: laser only (default); use: predict the motion from the recorded odometry; "
                 "FILE: from a trajectory in the TUM format. With --set map_with_known_poses=true "
                 "its poses are taken as they are")
      ->check(CLI::IsMember({"none", "use"}) | CLI::ExistingFile);
  app.add_option("--loops", arguments.loops,
                 "use: search for loops and correct the map with a pose graph; none: one map that "
                 "grows (default: parameter graph)")
      ->check(CLI::IsMember({"none", "use"}));
  app.add_flag("--polish", arguments.run.polish,
               "at the end, match every scan once more with the finished map");
  app.add_option("--imu", arguments.imu,
                 "use: roll, pitch and yaw rate from the recorded IMU (default); none: the vehicle "
                 "is level")
      ->check(CLI::IsMember({"none", "use"}));
  app.add_option("--filter", arguments.filter,
                 "use: the pose filter runs as in mav.launch, where the IMU has gyro and "
                 "accelerometer and no odometry is used (default); none: without")
      ->check(CLI::IsMember({"none", "use"}));
  app.add_option("--set", arguments.settings, "name=value: sets a parameter; overrides --config")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  addLaserPoseOption(app, arguments.laser_pose);
  addTopicOptions(app, arguments.topics);
  addRunOptions(app, arguments.run);
  app.add_flag("--no-timing", arguments.no_timing,
               "omit times and memory from the files, so that two runs give identical files");
  app.add_flag("--quiet", arguments.quiet, "print only warnings and errors");
}

SlamConfig configOf(const MappingArguments& arguments) {
  SlamConfig config;
  if (!arguments.config.empty()) loadParameters(arguments.config, config);
  applySettings(arguments.settings, config);
  if (!arguments.loops.empty()) config.mapper.window.enabled = arguments.loops == "use";
  if (arguments.run.polish && !config.mapper.usesGraph())
    throw std::runtime_error("--polish needs the pose graph; leave out --loops none");
  if (!arguments.session.empty() || !arguments.save_session.empty()) {
    if (arguments.loops == "none")
      throw std::runtime_error("--loops none has no session; leave it out, or the session");
    config.mapper.window.enabled = true;
  }
  return config;
}

RunInfo runInfoOf(const MappingArguments& arguments, const SlamConfig& config,
                  const Recording& recording) {
  RunInfo info;
  info.recording = fs::path(arguments.recording()).filename().string();
  info.description = recording.description();
  info.hash = hashOfFiles(arguments.recordings);
  if (arguments.app != nullptr) info.options = optionsOf(*arguments.app);
  info.config = config;
  info.odometry = arguments.usesOdometry();
  info.timing = !arguments.no_timing;
  return info;
}

std::unique_ptr<Recording> openFor(const MappingArguments& arguments) {
  RecordingOptions options = arguments.topics;
  options.base_T_laser = laserPoseOf(arguments.laser_pose);
  options.stop = stopRequested;
  std::unique_ptr<Recording> recording = openRecording(arguments.recordings, options);
  if (arguments.odometry == "use" && !recording->hasOdometry()) {
    throw std::runtime_error(arguments.recording() + ": has no odometry; use --odometry none");
  }
  return recording;
}

std::string nameOf(const std::string& recording) {
  fs::path name = fs::path(recording).filename();
  for (const char* ending : {".bz2", ".gz", ".xz", ".bag", ".clf", ".log", ".csv", ".dat"}) {
    if (name.extension() == ending && name != ending) name = name.stem();
  }
  return name.string();
}

void prepareOutput(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error)) {
    throw std::runtime_error("cannot write to " + folder.string() +
                             ": it is a file, not a folder; choose another --output");
  }
  fs::create_directories(folder, error);
  if (error) {
    throw std::runtime_error("cannot create the output folder " + folder.string() + ": " +
                             error.message() + "; choose another --output");
  }
  requireWritable(folder.string());
}

void stopOnSignals() {
  std::signal(SIGINT, requestStop);
  std::signal(SIGTERM, requestStop);
}

bool stopRequested() { return stop_requested != 0; }

OfflineRun mapWithProgress(Recording& recording, const SlamConfig& config,
                           const MappingArguments& arguments) {
  if (config.mapper.known_poses && !arguments.usesOdometry()) {
    throw std::invalid_argument(
        "map_with_known_poses needs poses; add --odometry use, or --odometry FILE with a "
        "trajectory in the TUM format");
  }
  RunOptions options = arguments.run;
  options.use_odometry = arguments.usesOdometry();
  if (arguments.hasOdometryFile()) options.odometry = sortedTum(arguments.odometry);
  options.use_imu = arguments.imu == "use";
  options.use_filter = arguments.filter == "use" && !options.use_odometry;
  options.base_T_laser = laserPoseOf(arguments.laser_pose);
  loadSessionFor(arguments, config, options);
  ProgressBar bar(stderr, ::isatty(STDERR_FILENO) == 1);
  OfflineRun run = runOffline(recording, config, options, [&](const OfflineProgress& progress) {
    if (!arguments.quiet) bar.update(progress);
    return !stopRequested();
  });
  if (!arguments.quiet) bar.finish();
  if (!run.scans.empty()) return run;
  // Without a pose there is nothing to write.
  printWarnings("warning: ", run);
  throw std::runtime_error(arguments.recording() + ": no scan could be used: " + run.mainProblem() +
                           (options.use_imu ? imuAdvice(run) : ""));
}

void printWarnings(const std::string& prefix, const OfflineRun& run) {
  for (const std::string& warning : run.warnings) {
    std::fprintf(stderr, "%s%s\n", prefix.c_str(), warning.c_str());
  }
}

void writeOutputs(const fs::path& folder, const OfflineRun& run, const RunInfo& info,
                  const std::vector<NamedContent>& others) {
  std::vector<ScanCovariance> covariances;
  std::vector<ScanRow> rows;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    covariances.push_back({run.trajectory[i].stamp, run.scans[i].uncertain});
    rows.push_back(rowOf(run.trajectory[i], run.scans[i]));
  }
  const std::string stats =
      statsOf(run, info).dump(kJsonIndent, ' ', false, nlohmann::json::error_handler_t::replace);
  std::vector<NamedContent> files = {{"trajectory.tum", tumText(run.trajectory)},
                                     {"covariances.txt", covariancesText(covariances)},
                                     {"scans.csv", scansText(rows)},
                                     {"stats.json", stats + "\n"},
                                     {"thumbnail.png", renderMap(run.map, kThumbnailPixels).png},
                                     {"report.html", reportHtml(run, info)}};
  if (run.graph) {
    files.push_back({"loops.csv", loopsText(*run.graph)});
    files.push_back({"graph.g2o", g2oText({run.graph->graph, {}})});
  }
  files.insert(files.end(), others.begin(), others.end());
  writeMapFolder(folder.string(), run.map, files);
}

}  // namespace kestrel
