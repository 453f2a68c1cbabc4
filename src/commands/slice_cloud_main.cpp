// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/parameters/parameters.h"
#include "kestrel_slam/recording/cloud_file.h"
#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/recording/reference.h"
#include "kestrel_slam/report/slice_plot.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> files;
  std::string output;
  std::vector<std::string> settings;
  RecordingOptions topics;
  std::size_t pictures = 10;
};

void declareOptions(CLI::App& app, Options& options) {
  app.add_option("FILE", options.files, "rosbags with PointCloud2, .pcd, .pcd.bin or .bin files")
      ->required();
  app.add_option("--output", options.output, "output folder for the plots")->required();
  app.add_option("--set", options.settings,
                 "name=value: a parameter of the projector, such as height (of the base above the "
                 "floor, m), "
                 "laser_z_min_value and laser_z_max_value (limits of the slice, m)")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--pictures", options.pictures, "N: plot the first N frames of each file")
      ->capture_default_str();
  app.add_option("--scan-topic", options.topics.scan_topic, "bags: topic of the clouds");
  app.add_option("--base-frame", options.topics.base_frame, "bags: frame of the vehicle");
}

ScanProjector projectorOf(const Options& options) {
  SlamConfig config;
  applySettings(options.settings, config);
  return ScanProjector(config.projector);
}

/// Slices the frames one by one, prints a line for each and plots the first ones.
class Slicer {
 public:
  explicit Slicer(const Options& options)
      : options_(options), projector_(projectorOf(options)), folder_(options.output) {
    options_.topics.prefer_clouds = true;
    std::error_code error;
    fs::create_directories(folder_, error);
    if (!fs::is_directory(folder_, error)) {
      throw std::runtime_error("cannot create the output folder " + options.output +
                               "; choose another --output");
    }
    std::printf("%-32s %8s %6s %6s %8s %8s\n", "frame", "points", "hits", "clears", "floor",
                "outside");
  }

  void addFile(const std::string& path) {
    const std::string name = fs::path(path).stem().string();
    if (!isBag(path)) {
      addFrame(name, 0, readCloudFile(path), Eigen::Isometry3d::Identity());
      return;
    }
    const std::unique_ptr<Recording> recording = openRecording(path, options_.topics);
    RecordedScan scan;
    for (std::size_t i = 0; recording->next(scan); ++i) {
      if (!scan.cloud) {
        throw std::runtime_error(path +
                                 ": the scan topic has no clouds; choose a PointCloud2 topic " +
                                 "with --scan-topic, or another bag");
      }
      addFrame(name + "_" + frameNumber(i), i, *scan.cloud, scan.base_T_laser);
    }
    std::fflush(stdout);
    for (const std::string& warning : recording->warnings()) {
      std::fprintf(stderr, "warning: %s: %s\n", path.c_str(), warning.c_str());
    }
  }

  std::size_t sliced() const { return sliced_; }

 private:
  static std::string frameNumber(std::size_t index) {
    char text[32];
    std::snprintf(text, sizeof text, "%04zu", index);
    return text;
  }

  void addFrame(const std::string& name, std::size_t index, const PointCloud& cloud,
                const Eigen::Isometry3d& base_T_lidar) {
    const Projection projection = projector_.project(cloud, base_T_lidar);
    if (projection.error != ScanError::kNone) {
      std::printf("%-32s %8zu  %s: %s\n", name.c_str(), cloud.points.size(),
                  toString(projection.error), projection.message.c_str());
      return;
    }
    ++sliced_;
    const std::size_t hits = projection.scan.hitCount();
    const BeamCounts& counts = projection.counts;
    std::printf("%-32s %8zu %6zu %6zu %8zu %8zu\n", name.c_str(), cloud.points.size(), hits,
                projection.scan.rays.size() - hits, counts.floor, counts.outside + counts.ceiling);
    if (index >= options_.pictures) return;
    writeSlicePlot((folder_ / (name + ".png")).string(), name, cloud, base_T_lidar, projection.scan,
                   projector_.config().beams.max_range_m);
  }

  Options options_;
  ScanProjector projector_;
  fs::path folder_;
  std::size_t sliced_ = 0;
};

void run(const Options& options) {
  Slicer slicer(options);
  for (const std::string& file : options.files) slicer.addFile(file);
  if (slicer.sliced() == 0)
    throw std::runtime_error("no frame could be sliced; see the messages above");
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  Options options;
  CLI::App app(
      "Extracts from clouds of a 3D lidar the horizontal slice that is used for mapping, and\n"
      "plots it over the cloud, seen from above. The vehicle is assumed to be level.");
  declareOptions(app, options);
  return runTool("slice_cloud", app, argc, argv, [&] { run(options); });
}
