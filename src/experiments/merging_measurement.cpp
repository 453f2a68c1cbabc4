// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/merging_measurement.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <utility>

#include "kestrel_slam/graph/optimizer.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/recording/simulated_recording.h"
#include "kestrel_slam/simulation/flight_simulator.h"

namespace kestrel {
namespace {

/// "intel" of "/data/intel.clf.bz2".
std::string nameOfFile(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  return name.substr(0, name.find('.'));
}

VehicleModel slowLaser() {
  constexpr double kRate = 10.0;  // Hz: enough for a slow flight
  VehicleModel model = quadrotorWith("utm30lx");
  model.laser->rate_hz = kRate;
  return model;
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

MappedVehicle mapVehicle(const std::string& name, Recording& recording, SlamConfig config,
                         const RunOptions& options) {
  config.mapper.window.enabled = true;
  const OfflineRun run = runOffline(recording, config, options);
  if (run.scans.empty()) throw std::runtime_error(name + ": " + run.mainProblem());
  if (!run.session) throw std::runtime_error(name + ": nothing was mapped");
  MappedVehicle mapped;
  mapped.map = vehicleMapOf(name, *run.session);
  mapped.trajectory = run.trajectory;
  const std::vector<LocalKeyframe>& keyframes = mapped.map.keyframes;
  std::size_t next = 0;  // keyframe
  for (const StampedPose& scan : run.trajectory) {
    if (next < keyframes.size() && keyframes[next].keyframe->stamp == scan.stamp) ++next;
    mapped.keyframe_before.push_back(next == 0 ? 0 : next - 1);
  }
  return mapped;
}

MappedVehicle mapVehicle(const VehicleRecording& vehicle, const SlamConfig& config) {
  const std::unique_ptr<Recording> recording = openRecording(vehicle.path);
  RunOptions options;
  options.use_odometry = vehicle.use_odometry && recording->hasOdometry();
  options.perturbation.skip_scans = vehicle.first;
  options.max_scans = vehicle.last;
  return mapVehicle(vehicle.name, *recording, config, options);
}

MappedVehicle mapOffice(std::uint64_t seed, OfficeChange change, std::uint64_t vehicle,
                        const SlamConfig& config) {
  SimulatedRecording recording(randomOffice(seed, change, vehicle), slowLaser(),
                               10 * seed + vehicle);
  const std::string name = "office_" + std::to_string(seed) + "_" + std::to_string(vehicle);
  return mapVehicle(name, recording, config, RunOptions());
}

Session officeSession(std::uint64_t seed, std::uint64_t vehicle, std::size_t rooms,
                      const SlamConfig& config) {
  SimulatedRecording recording(randomOffice(seed, OfficeChange::kNone, vehicle, rooms), slowLaser(),
                               10 * seed + vehicle);
  SlamConfig with_graph = config;
  with_graph.mapper.window.enabled = true;
  OfflineRun run = runOffline(recording, with_graph, RunOptions());
  if (!run.session) throw std::runtime_error("nothing was mapped");
  return std::move(*run.session);
}

VehicleMap grownTo(const VehicleMap& map, std::size_t count) {
  VehicleMap grown;
  grown.name = map.name;
  grown.keyframes.assign(map.keyframes.begin(),
                         map.keyframes.begin() + static_cast<std::ptrdiff_t>(count));
  for (KnownPlace place : map.places) {
    place.last = std::min(place.last, count);
    if (place.first < place.last) grown.places.push_back(place);
  }
  for (const PoseEdge& edge : map.edges)
    if (edge.from < count && edge.to < count) grown.edges.push_back(edge);
  PoseGraph graph;
  for (std::size_t i = 0; i < count; ++i) graph.vertices.push_back({map.poses[i]});
  graph.edges = grown.edges;
  optimize(graph);
  for (const PoseVertex& vertex : graph.vertices) grown.poses.push_back(vertex.pose);
  return grown;
}

Trajectory inWorld(const MappedVehicle& mapped, const MergeResult& merged, std::size_t vehicle) {
  Trajectory result = mapped.trajectory;
  for (std::size_t i = 0; i < result.size() && !mapped.map.keyframes.empty(); ++i) {
    const std::size_t keyframe = mapped.keyframe_before[i];
    result[i].pose =
        merged.poses[vehicle][keyframe] * mapped.map.poses[keyframe].between(result[i].pose);
  }
  return result;
}

}  // namespace kestrel
