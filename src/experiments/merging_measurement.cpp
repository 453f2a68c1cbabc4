// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/merging_measurement.h"

#include <filesystem>
#include <memory>
#include <stdexcept>

#include "kestrel_slam/graph/submap_graph.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/recording.h"

namespace kestrel {
namespace {

/// "intel" of "/data/intel.clf.bz2".
std::string nameOfFile(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  return name.substr(0, name.find('.'));
}

}  // namespace

std::vector<VehicleRecording> cutRecording(const std::string& path, std::size_t parts,
                                           bool use_odometry) {
  const std::string name = nameOfFile(path);
  if (parts == 1) return {{name, path, 0, std::numeric_limits<std::size_t>::max(), use_odometry}};
  const std::size_t scans = openRecording(path)->scanCount();
  std::vector<VehicleRecording> result;
  for (std::size_t i = 0; i < parts; ++i) {
    result.push_back({name + "_" + std::to_string(i + 1), path, scans * i / parts,
                      scans * (i + 1) / parts, use_odometry});
  }
  return result;
}

MappedVehicle mapVehicle(const VehicleRecording& vehicle, SlamConfig config) {
  const std::unique_ptr<Recording> recording = openRecording(vehicle.path);
  config.mapper.window.enabled = true;
  MappedVehicle mapped;
  RunOptions options;
  options.use_odometry = vehicle.use_odometry && recording->hasOdometry();
  options.perturbation.skip_scans = vehicle.first;
  options.max_scans = vehicle.last;
  options.graph_observer = [&](const SubmapGraph& graph) {
    mapped.map = vehicleMapOf(vehicle.name, graph);
  };
  const OfflineRun run = runOffline(*recording, config, options);
  if (run.scans.empty()) throw std::runtime_error(vehicle.path + ": " + run.mainProblem());
  mapped.map.name = vehicle.name;
  mapped.trajectory = run.trajectory;
  std::size_t keyframes = 0;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    if (run.scans[i].inserted) ++keyframes;
    mapped.keyframe_before.push_back(keyframes == 0 ? 0 : keyframes - 1);
  }
  return mapped;
}

Trajectory inWorld(const MappedVehicle& mapped, const MergeResult& merged, std::size_t vehicle) {
  Trajectory result = mapped.trajectory;
  for (std::size_t i = 0; i < result.size() && !mapped.map.keyframes.empty(); ++i) {
    const std::size_t keyframe = mapped.keyframe_before[i];
    result[i].pose = merged.poses[vehicle][keyframe] *
                     mapped.map.keyframes[keyframe].local_T_base.between(result[i].pose);
  }
  return result;
}

MapSnapshot mapOf(const std::vector<VehicleMap>& vehicles, const MergeResult& merged,
                  std::size_t vehicle, const OccupancyGridConfig& config) {
  OccupancyGrid grid(config);
  for (std::size_t v = 0; v < vehicles.size(); ++v) {
    if (merged.group[v] != merged.group[vehicle]) continue;
    for (std::size_t i = 0; i < vehicles[v].keyframes.size(); ++i) {
      const Keyframe& keyframe = *vehicles[v].keyframes[i].keyframe;
      grid.insert(keyframe.planarScan(), merged.poses[v][i], keyframe.new_view);
    }
  }
  return grid.snapshot();
}

}  // namespace kestrel
