// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/offline/stats.h"
#include "kestrel_slam/parameters/parameters.h"
#include "kestrel_slam/recording/recording.h"

namespace CLI {
class App;
}

namespace kestrel {

/// What the tools that map a recording read from the command line.
struct MappingArguments {
  std::string recording;
  std::string config;  ///< YAML file with parameters; may be empty
  std::string odometry = "none";
  std::string imu = "use";
  std::string filter = "use";
  std::vector<std::string> settings;  ///< name=value, after those of the file
  RecordingOptions topics;
  std::vector<double> laser_pose;  ///< x, y (m), yaw (degrees) of the laser; may be empty
  RunOptions run;                  ///< but the sensors, which are in the texts above
  bool no_timing = false;
  bool quiet = false;
};

/// Declares the options of `arguments`; RECORDING may be missing, so that the tool can do without.
void addMappingOptions(CLI::App& app, MappingArguments& arguments);

/// Declares `--laser-pose x,y,yaw`, in m and degrees, and what it says: base_T_laser, or nothing
/// where it was not given.
void addLaserPoseOption(CLI::App& app, std::vector<double>& x_y_yaw);
std::optional<Eigen::Isometry3d> laserPoseOf(const std::vector<double>& x_y_yaw);

/// The parameters of `--config` and `--set`, validated. Throws std::runtime_error or
/// std::invalid_argument with one line that names what is wrong.
SlamConfig configOf(const MappingArguments& arguments);

/// What is known of the outputs before the run.
RunInfo runInfoOf(const MappingArguments& arguments, const SlamConfig& config,
                  const Recording& recording);

/// Opens the recording. Throws as openRecording does, and where its odometry is asked for but
/// missing.
std::unique_ptr<Recording> openFor(const MappingArguments& arguments);

/// The file's name without its folder and without the endings of recordings.
std::string nameOf(const std::string& recording);

/// Makes the folder and tries to write into it, so that a long run is not lost at its end. Throws
/// std::runtime_error.
void prepareOutput(const std::filesystem::path& folder);

/// From now on SIGINT and SIGTERM only end the mapping: what has been mapped is still written.
void stopOnSignals();
/// Whether such a signal has come.
bool stopRequested();

/// Maps with a progress bar on standard error, unless it is to be quiet. Throws std::runtime_error
/// where not a single scan could be used.
OfflineRun mapVisibly(Recording& recording, const SlamConfig& config,
                      const MappingArguments& arguments);

/// Prints the warnings of a run to standard error, each line after `prefix`.
void printWarnings(const std::string& prefix, const OfflineRun& run);

/// Writes map.pgm, map.yaml, trajectory.tum, stats.json and report.html.
void writeOutputs(const std::filesystem::path& folder, const OfflineRun& run, const RunInfo& info);

}  // namespace kestrel
