// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iomanip>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/commands/mapping_command.h"
#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/evaluation/labeled_objects.h"
#include "kestrel_slam/evaluation/track_file.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/lidar/static_map.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/recording/cloud_file.h"
#include "kestrel_slam/recording/kitti_labels.h"
#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/recording/reference.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> files;
  std::string output, calibration, labels;
  RecordingOptions topics;
  double rate_hz = 10.0;
  std::size_t max_scans = 0;
  LabelGoal goal;
  double min_tracked = 0.0;  ///< %
};

constexpr int kStampDecimals = 6, kPoseDecimals = 6;
constexpr std::size_t kMapEvery = 10;  ///< sweeps
/// The middle of a track is in the box of its label, or this near to it, m.
constexpr double kLabelMargin = 0.5;
constexpr double kPercent = 100.0;

/// Runs the tracker on all sweeps and collects what is written.
class CloudRun {
 public:
  explicit CloudRun(const Options& options)
      : options_(options), static_map_(CloudTrackerConfig().surface_resolution_m) {
    if (!options.calibration.empty()) camera_ = readKittiCalibration(options.calibration);
    if (options.labels.empty()) return;
    for (const KittiLabel& label : readKittiLabels(options.labels, camera_)) {
      labels_[label.frame].push_back(label);
    }
  }

  void addFile(const std::string& path) {
    if (!isBag(path)) {
      PointCloud cloud = readCloudFile(path);
      // Files have no stamps.
      cloud.stamp = static_cast<double>(sweeps_) / options_.rate_hz;
      add(std::move(cloud));
      return;
    }
    RecordingOptions topics = options_.topics;
    topics.prefer_clouds = true;
    const std::unique_ptr<Recording> recording = openRecording(path, topics);
    RecordedScan scan;
    while (!isFull() && recording->next(scan)) {
      if (!scan.cloud) {
        throw std::runtime_error(path +
                                 ": the scan topic has no clouds; choose a PointCloud2 "
                                 "topic with --scan-topic, or another bag");
      }
      add(std::move(*scan.cloud));
    }
  }

  void write(const fs::path& folder) {
    if (frames_.empty()) throw std::runtime_error("no sweep could be used; see the warnings above");
    static_map_.add(tracker_);
    const auto writeTo = [&](const char* name, const std::string& content) {
      writeFileAtomically((folder / name).string(), content);
    };
    writeTo("trajectory.tum", trajectory_.str());
    writeTo("odom_trajectory.tum", tumText(path_));
    writeTo("tracks.csv", tracksCsv(frames_));
    writeTo("tracks.json", tracksJson(frames_));
    writeTo("tracks_kitti.txt", kitti_.str());
    writeTo("map.pcd", static_map_.pcd());
    writeTo("map.bt", static_map_.octomap());
  }

  void printSummary() const {
    std::set<long> shown;
    for (const TrackFrame& frame : frames_) {
      for (const Track& track : frame.tracks) {
        if (track.isShown()) shown.insert(track.id);
      }
    }
    std::printf("%-12s%zu of %zu used, %zu of them without localization\n", "sweeps",
                frames_.size(), sweeps_, lost_);
    std::printf("%-12s%zu objects that moved\n", "tracks", shown.size());
    std::printf("%-12s%zu voxels\n", "map", static_map_.points().size());
  }

  /// One line for each labeled object that moves. False: one of them was tracked too seldom.
  bool printLabels() const {
    if (options_.labels.empty()) return true;
    const std::vector<LabeledObject> objects = labeledObjects(sightings_, options_.goal);
    std::size_t missed = 0;
    std::printf("\n%8s  %-14s %7s %7s %7s %9s %7s\n", "object", "type", "m/s", "sweeps", "shown",
                "not shown", "tracks");
    for (const LabeledObject& object : objects) {
      std::printf("%8ld  %-14s %7.1f %7zu %6.1f%% %9zu %7zu\n", object.id, object.type.c_str(),
                  object.speed, object.sweeps, kPercent * object.share(), object.hidden,
                  object.tracks.size());
      if (kPercent * object.share() < options_.min_tracked) ++missed;
    }
    std::printf("%zu labeled objects move, %zu of them are tracked less than %g %% of the time\n",
                objects.size(), missed, options_.min_tracked);
    return missed == 0;
  }

  bool isFull() const { return options_.max_scans > 0 && sweeps_ >= options_.max_scans; }

 private:
  void add(PointCloud cloud) {
    const std::size_t frame = sweeps_++;
    const LidarSweep sweep{std::move(cloud), {}};
    const CloudTracker::Result& result = tracker_.process(sweep);
    if (!result.problem.empty()) warn(result.problem);
    if (!result.used) return;
    if (!result.localized) ++lost_;
    const double stamp = *tracker_.stamp();
    addPose(stamp, result.pose);
    TrackFrame tracks{stamp, {}, result.saturated};
    for (const CloudTrack& track : result.tracks) {
      tracks.tracks.push_back(track.plane);
      if (track.isShown()) addLabel(static_cast<long>(frame), track, result.pose);
    }
    for (const KittiLabel& label : labels_[static_cast<long>(frame)]) {
      sightings_.push_back(sightingOf(label, sweep.cloud, result));
    }
    frames_.push_back(std::move(tracks));
    if (frames_.size() % kMapEvery == 0) static_map_.add(tracker_);
  }

  LabelSighting sightingOf(const KittiLabel& label, const PointCloud& cloud,
                           const CloudTracker::Result& result) const {
    LabelSighting sighting;
    sighting.stamp = cloud.stamp;
    sighting.id = label.id;
    sighting.type = label.type;
    sighting.place = (result.pose * label.center).head<2>();
    for (const PointCloud::Point& p : cloud.points) {
      if (isInLabel(label, {p.x, p.y, p.z}, 0.0)) ++sighting.points;
    }
    for (const CloudTrack& track : result.tracks) {
      Eigen::Vector3d at =
          result.pose.inverse() *
          Eigen::Vector3d(track.plane.position.x(), track.plane.position.y(), track.z);
      at.z() = label.center.z();
      if (!isInLabel(label, at, kLabelMargin)) continue;
      sighting.has_track = true;
      if (!track.isShown() || sighting.is_shown) continue;
      sighting.is_shown = true;
      sighting.track = track.plane.id;
    }
    return sighting;
  }

  /// Each problem once.
  void warn(const std::string& problem) {
    if (warned_.insert(problem).second) {
      std::fprintf(stderr, "warning: sweep %zu: %s\n", sweeps_ - 1, problem.c_str());
    }
  }

  void addPose(double stamp, const Eigen::Isometry3d& pose) {
    const Eigen::Quaterniond q(pose.linear());
    const Eigen::Vector3d t = pose.translation();
    trajectory_ << std::fixed << std::setprecision(kStampDecimals) << stamp
                << std::setprecision(kPoseDecimals) << ' ' << t.x() << ' ' << t.y() << ' ' << t.z()
                << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << ' ' << q.w() << '\n';
    path_.push_back({stamp, toPose2(pose)});
  }

  void addLabel(long frame, const CloudTrack& track, const Eigen::Isometry3d& pose) {
    const OrientedBox& box = track.plane.box;
    KittiLabel label;
    label.frame = frame;
    label.id = track.plane.id;
    label.type = track.plane.size == SizeClass::kVehicle  ? "Car"
                 : track.plane.size == SizeClass::kMedium ? "Cyclist"
                                                          : "Pedestrian";
    const double height = std::max(track.top - track.bottom, 0.1);
    label.center = pose.inverse() * Eigen::Vector3d(box.center.x(), box.center.y(),
                                                    0.5 * (track.top + track.bottom));
    label.size << box.size, height;
    label.yaw = box.yaw - yawOf(Eigen::Quaterniond(pose.linear()));
    kitti_ << kittiLine(label, camera_);
  }

  const Options& options_;
  CloudTracker tracker_;
  StaticMap static_map_;
  Eigen::Isometry3d camera_ = plainKittiCamera();
  std::size_t sweeps_ = 0, lost_ = 0;
  std::ostringstream trajectory_, kitti_;
  Trajectory path_;
  std::vector<TrackFrame> frames_;
  std::set<std::string> warned_;
  std::map<long, std::vector<KittiLabel>> labels_;  ///< by frame
  std::vector<LabelSighting> sightings_;
};

/// False: a limit that was asked for is missed.
bool run(const Options& options) {
  const fs::path folder =
      options.output.empty() ? nameOf(options.files.front()) + "_tracks" : options.output;
  prepareOutput(folder);
  CloudRun run(options);
  for (const std::string& file : options.files) {
    if (!run.isFull()) run.addFile(file);
  }
  run.write(folder);
  run.printSummary();
  std::printf("%-12s%s\n", "output", folder.string().c_str());
  return run.printLabels();
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  Options options;
  CLI::App app(
      "Localizes a 3D lidar by its sweeps alone, maps what stands and tracks what moves. Writes "
      "the\n"
      "trajectory, the tracks and the static map (PCD, OctoMap).");
  app.add_option("FILE", options.files,
                 "rosbags with PointCloud2, or .pcd, .pcd.bin or .bin files in their order")
      ->required();
  app.add_option("--output", options.output, "output folder (default: ./<name>_tracks)");
  app.add_option("--rate", options.rate_hz, "Hz: sweeps per second of files without stamps")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--max-scans", options.max_scans, "N: only the first N sweeps");
  app.add_option("--scan-topic", options.topics.scan_topic, "bags: topic of the clouds");
  app.add_option("--base-frame", options.topics.base_frame, "bags: frame of the vehicle");
  app.add_option("--calibration", options.calibration,
                 "calibration file of the KITTI tracking benchmark, for tracks_kitti.txt");
  CLI::Option* labels = app.add_option(
      "--labels", options.labels,
      "label file of the KITTI tracking benchmark: prints how long every labeled object that moves "
      "was tracked");
  app.add_option("--min-tracked", options.min_tracked,
                 "%: exit code 3 if a labeled object was tracked less of its time")
      ->needs(labels)
      ->check(CLI::Range(0.0, kPercent));
  app.add_option("--min-speed", options.goal.min_speed, "m/s: slower labeled objects do not count")
      ->needs(labels)
      ->capture_default_str();
  app.add_option("--min-points", options.goal.min_points,
                 "sweeps with fewer returns from a labeled object do not count")
      ->needs(labels)
      ->capture_default_str();
  bool reached = true;
  const int code = runTool("track_clouds", app, argc, argv, [&] { reached = run(options); });
  return code == 0 && !reached ? kLimitMissed : code;
}
