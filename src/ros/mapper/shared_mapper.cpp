// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/shared_mapper.h"

#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>

namespace kestrel {

using Lock = std::lock_guard<FairMutex>;

SharedMapper::SharedMapper(const MapperConfig& config, const LoopConfig& loops,
                           bool keep_out_moving)
    : config_(config),
      loops_(loops),
      mapping_(config, keep_out_moving),
      graph_(config.usesGraph() ? std::make_unique<GraphWorker>(config, loops) : nullptr) {}

MapperResult SharedMapper::process(PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                                   const ros::Time& stamp) {
  const Lock lock(mutex_);
  MapperResult result = mapping_.process(scan, odom_T_base);
  stamp_ = stamp;
  memory_bytes_ = mapping_.mapper().memoryBytes();
  full_ = result.map_full;
  if (result.inserted && !graph_) ++version_;
  if (!graph_) return result;
  graph_->add(scan, result);
  const GraphCorrection correction = graph_->correction();
  const bool lost = lost_.add(result, scan.time);
  result = correction.inMap(std::move(result));
  if (lost) {
    mapping_.reset(result.pose);
    graph_->beginPart();
  }
  return result;
}

void SharedMapper::configure(const MapperConfig& config, const LoopConfig& loops) {
  const Lock lock(mutex_);
  config_ = config;
  loops_ = loops;
  mapping_.configure(config);
  if (graph_) graph_->configure(loops);
}

std::pair<MapperConfig, LoopConfig> SharedMapper::parameters() const {
  const Lock lock(mutex_);
  return {config_, loops_};
}

void SharedMapper::reset(const Pose2& map_T_base) {
  const Lock lock(mutex_);
  mapping_.reset(map_T_base);
  if (graph_) graph_->reset();
  memory_bytes_ = mapping_.mapper().memoryBytes();
  full_ = false;
  ++map_number_;
  ++version_;
}

void SharedMapper::requireGraph() const {
  if (!graph_) throw std::runtime_error("sessions need the parameter graph");
}

/// The graph and its map are made before the lock is taken.
void SharedMapper::continueWith(GraphRecord record,
                                const std::optional<GaussianPose2>& map_T_base) {
  requireGraph();
  const auto [config, loops] = parameters();
  auto graph = std::make_unique<SubmapGraph>(config, loops, std::move(record));
  auto map = std::make_unique<ComposedMap>(config.grid);
  map->add(*graph);
  graph->beginPart(map_T_base);
  const Lock lock(mutex_);
  mapping_.reset(map_T_base ? map_T_base->mean : Pose2());
  graph_->replace(std::move(graph), std::move(map));
  graph_->configure(loops_);  // they may have changed meanwhile
  full_ = false;
  ++map_number_;
  ++version_;
}

GraphSnapshot SharedMapper::graphSnapshot() {
  requireGraph();
  return graph_->snapshot();
}

void SharedMapper::localizeIn(Submap map) {
  const Lock lock(mutex_);
  graph_.reset();
  mapping_.localizeIn(std::move(map));
  memory_bytes_ = mapping_.mapper().memoryBytes();
  ++map_number_;
  ++version_;
}

bool SharedMapper::relocalize() {
  const Lock lock(mutex_);
  if (mapping_.localizer() == nullptr) return false;
  mapping_.localizer()->relocalize();
  return true;
}

void SharedMapper::setPose(const Pose2& map_T_base) {
  const Lock lock(mutex_);
  mapping_.setPose(mapTLocal().inverse() * map_T_base);
}

void SharedMapper::restartMotion() {
  const Lock lock(mutex_);
  mapping_.restartMotion();
}

Pose2 SharedMapper::pose() const {
  const Lock lock(mutex_);
  return mapTLocal() * mapping_.mapper().pose();
}

MapChanges SharedMapper::takeChanges() {
  constexpr std::size_t kTiles = 32;  // copied in some tens of microseconds
  MapChanges result;
  result.tiles.reserve(kTiles);
  const Lock lock(mutex_);
  result.version = version();
  if (graph_) {
    result.complete = !graph_->takeChangedTiles(kTiles, result.tiles, result.map_number);
  } else {
    result.complete = !mapping_.takeChangedTiles(kTiles, result.tiles);
    result.map_number = map_number_;
  }
  result.stamp = stamp_;
  return result;
}

}  // namespace kestrel
