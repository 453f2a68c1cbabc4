// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/map/map_folder.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/offline/stats.h"
#include "kestrel_slam/parameters/parameters.h"
#include "kestrel_slam/recording/recording.h"

namespace CLI {
class App;
}

namespace kestrel {

/// Command line arguments of the tools that map a recording.
struct MappingArguments {
  std::vector<std::string> recordings;  ///< one file, or the bags of a recording that was split
  std::string config;                   ///< YAML file with parameters; may be empty
  std::string odometry = "none";        ///< none, use, or a file in the TUM format
  std::string loops;                    ///< none or use; "": as the parameter says
  std::string imu = "use";
  std::string filter = "use";
  std::vector<std::string> settings;  ///< name=value; these override the file
  RecordingOptions topics;
  std::vector<double> laser_pose;  ///< x, y (m), yaw (degrees) of the laser; may be empty
  RunOptions run;                  ///< without the choice of sensors, see `odometry` and `imu`
  std::string session;             ///< session file that is continued; "": none
  std::string start = "last";      ///< last, unknown or X,Y,YAW (m and degrees)
  std::string mode = "mapping";    ///< or localization
  std::string map;                 ///< YAML file of a map to localize in; "": that of `session`
  std::string save_session;        ///< file for the session after the run; "": none
  const CLI::App* app = nullptr;   ///< where the options were declared
  bool no_timing = false;
  bool quiet = false;

  bool usesOdometry() const { return odometry != "none"; }
  bool hasOdometryFile() const { return usesOdometry() && odometry != "use"; }
  /// The first file; "" if there is none.
  std::string recording() const { return recordings.empty() ? "" : recordings.front(); }
};

/// Declares the options of `arguments`. RECORDING is optional; the tool must check whether it is
/// needed.
void addMappingOptions(CLI::App& app, MappingArguments& arguments);

/// Declares `--session`, `--start`, `--save-session`, `--mode` and `--map`.
void addSessionOptions(CLI::App& app, MappingArguments& arguments);
/// Reads the session that is continued, or the map to localize in, into `run`. Throws
/// std::runtime_error with the file and the reason, also if the session of this run could not be
/// saved.
void loadSessionFor(const MappingArguments& arguments, const SlamConfig& config, RunOptions& run);
/// Saves the session of the run if that was asked for. Throws std::runtime_error.
void saveSessionOf(const OfflineRun& run, const MappingArguments& arguments);

/// Declares `--laser-pose x,y,yaw` (m and degrees).
void addLaserPoseOption(CLI::App& app, std::vector<double>& x_y_yaw);
/// base_T_laser from the values of `--laser-pose`; nothing if it was not given.
std::optional<Eigen::Isometry3d> laserPoseOf(const std::vector<double>& x_y_yaw);

/// The validated parameters of `--config` and `--set`. Throws std::runtime_error or
/// std::invalid_argument with one line that describes the error.
SlamConfig configOf(const MappingArguments& arguments);

/// The part of the outputs that is known before the run.
RunInfo runInfoOf(const MappingArguments& arguments, const SlamConfig& config,
                  const Recording& recording);

/// Opens the recording. A signal (see stopOnSignals()) stops it with an exception. Throws like
/// openRecording(), and also if `--odometry use` is given but the
/// recording has no odometry.
std::unique_ptr<Recording> openFor(const MappingArguments& arguments);

/// The name of the file without folder and without extensions of recordings.
std::string nameOf(const std::string& recording);

/// Creates the folder and checks that it is writable, so that an error is found before a long run.
/// Throws std::runtime_error.
void prepareOutput(const std::filesystem::path& folder);

/// After this call, the first SIGINT or SIGTERM only stops the mapping, and the results so far are
/// still written; while a recording is being opened, it ends the program with a message. A second
/// one ends the program at once.
void stopOnSignals();
/// True after such a signal.
bool stopRequested();

/// Maps with a progress bar on standard error (none with `--quiet`). Throws std::runtime_error if
/// no scan could be used.
OfflineRun mapWithProgress(Recording& recording, const SlamConfig& config,
                           const MappingArguments& arguments);

/// Prints the warnings of a run to standard error; each line begins with `prefix`.
void printWarnings(const std::string& prefix, const OfflineRun& run);

/// Writes map.pgm, map.yaml, trajectory.tum, covariances.txt, scans.csv, stats.json, thumbnail.png,
/// report.html, with a pose graph also loops.csv and graph.g2o, and `others`. Throws
/// std::runtime_error.
void writeOutputs(const std::filesystem::path& folder, const OfflineRun& run, const RunInfo& info,
                  const std::vector<NamedContent>& others = {});

}  // namespace kestrel
