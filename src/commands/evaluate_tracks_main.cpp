// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "kestrel_slam/commands/mapping_command.h"
#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/evaluation/track_evaluation.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/recording/kitti_labels.h"

namespace kestrel {
namespace {

struct Options {
  std::string folder, truth, sensor_topic, json, kitti_calibration;
  std::vector<std::string> topics;
  std::vector<double> sensor_pose, bearings;
  double stamp_offset = 0.0;
  TrackEvaluationOptions evaluation;
};

constexpr double kPercent = 100.0;
/// Longest gap over which a path of a motion capture system is interpolated, s.
constexpr double kCaptureGap = 0.2;

void printRow(const char* name, const ClearMot& m) {
  std::printf("%-18s %7zu %7.1f %7.3f %7zu %7zu %7zu %9zu\n", name, m.truths, kPercent * m.mota(),
              m.motp(), m.misses, m.false_tracks, m.switches, m.fragments);
}

void print(const TrackEvaluation& e) {
  std::printf("%-18s %7s %7s %7s %7s %7s %7s %9s\n", "", "objects", "MOTA, %", "MOTP, m", "misses",
              "false", "switch", "fragments");
  printRow("all objects", e.all);
  printRow("moving objects", e.moving);
  std::printf("%zu scans, OSPA %.3f m, GOSPA %.3f m, one identity %.1f %% of the time\n",
              e.all.frames, e.ospa, e.gospa, kPercent * e.identity_share);
  std::printf(
      "moving objects without a shown track: %zu without any, %zu not confirmed, %zu not known to "
      "move, %zu not seen for too long\n",
      e.losses.no_track, e.losses.tentative, e.losses.not_moving, e.losses.unseen);
  std::printf("position rmse %.3f m", e.position_rmse);
  if (e.speeds > 0) std::printf(", velocity rmse %.3f m/s (%zu values)", e.speed_rmse, e.speeds);
  std::printf("\n");
}

nlohmann::ordered_json jsonOf(const ClearMot& m) {
  return {{"objects", m.truths},     {"mota", m.mota()},        {"motp_m", m.motp()},
          {"misses", m.misses},      {"false", m.false_tracks}, {"switches", m.switches},
          {"fragments", m.fragments}};
}

/// The labels have numbers of frames instead of stamps: frame n is line n of the trajectory.
std::vector<TrueObject> kittiObjects(const Options& options, const Trajectory& path) {
  std::vector<TrueObject> objects;
  const auto labels =
      readKittiLabels(options.truth, readKittiCalibration(options.kitti_calibration));
  for (const KittiLabel& label : labels) {
    if (label.frame < 0 || static_cast<std::size_t>(label.frame) >= path.size()) continue;
    objects.push_back(
        {path[static_cast<std::size_t>(label.frame)].stamp, label.id, label.center.head<2>()});
  }
  return objects;
}

void run(Options& options) {
  const std::filesystem::path folder = options.folder;
  if (!options.sensor_topic.empty()) options.evaluation.max_gap_s = kCaptureGap;
  if (options.sensor_pose.size() == 3) {
    const Eigen::Isometry3d pose = *laserPoseOf(options.sensor_pose);
    options.evaluation.base_T_sensor = {pose.translation().x(), pose.translation().y(),
                                        std::atan2(pose(1, 0), pose(0, 0))};
  }
  if (options.bearings.size() == 2) {
    options.evaluation.min_bearing = options.bearings[0] * kPi / 180.0;
    options.evaluation.max_bearing = options.bearings[1] * kPi / 180.0;
  }
  const Trajectory path = readTum((folder / "odom_trajectory.tum").string());
  std::vector<TrueObject> truth =
      options.kitti_calibration.empty()
          ? readTrueObjects(options.truth, options.topics, options.sensor_topic)
          : kittiObjects(options, path);
  for (TrueObject& object : truth) object.stamp += options.stamp_offset;
  const TrackEvaluation result =
      evaluateTracks(path, readTracks((folder / "tracks.csv").string()), truth, options.evaluation);
  print(result);
  if (options.json.empty()) return;
  const nlohmann::ordered_json json = {{"all", jsonOf(result.all)},
                                       {"moving", jsonOf(result.moving)},
                                       {"lost_without_track", result.losses.no_track},
                                       {"lost_tentative", result.losses.tentative},
                                       {"lost_not_moving", result.losses.not_moving},
                                       {"lost_unseen", result.losses.unseen},
                                       {"scans", result.all.frames},
                                       {"ospa_m", result.ospa},
                                       {"gospa_m", result.gospa},
                                       {"identity_share", result.identity_share},
                                       {"position_rmse_m", result.position_rmse},
                                       {"velocity_rmse_m_s", result.speed_rmse}};
  writeFileAtomically(options.json, json.dump(2) + "\n");
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  Options options;
  CLI::App app("Compares the tracks of track_recording with true positions.");
  app.add_option("FOLDER", options.folder, "output folder of track_recording")->required();
  app.add_option("TRUTH", options.truth,
                 "rosbag with leg_tracker/Person messages or motion capture, or a text file with "
                 "lines stamp,id,x,y in the frame of the sensor")
      ->required();
  app.add_option("--topic", options.topics,
                 "bags: topic of the people or of the poses of an object; once for each object")
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--sensor-topic", options.sensor_topic,
                 "bags with motion capture: topic of the poses of the sensor");
  app.add_option(
         "--sensor-pose", options.sensor_pose,
         "x,y,yaw in m and degrees: pose of the sensor of the true positions in the base frame")
      ->delimiter(',')
      ->expected(3);
  app.add_option("--bearings", options.bearings,
                 "MIN,MAX in degrees in the frame of the sensor: the part of the view in which all "
                 "objects are in TRUTH; tracks elsewhere are not compared")
      ->delimiter(',')
      ->expected(2);
  app.add_option("--kitti-calibration", options.kitti_calibration,
                 "calibration file: TRUTH is a label file of the KITTI tracking benchmark");
  app.add_option("--stamp-offset", options.stamp_offset,
                 "s, added to the stamps of the true positions, if their clock is another one");
  app.add_option("--distance", options.evaluation.max_distance_m, "largest distance of a match, m")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--json", options.json, "write the figures to this file");
  return runTool("evaluate_tracks", app, argc, argv, [&] { run(options); });
}
