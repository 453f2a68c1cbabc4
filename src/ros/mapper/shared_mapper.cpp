// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/shared_mapper.h"

#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "kestrel_slam/map/picture_map.h"
#include "kestrel_slam/session/graph_session.h"

namespace kestrel {

using Lock = std::lock_guard<FairMutex>;

namespace {

/// Added to the numbers of the maps that are not those of the graph, which has numbers of its own.
constexpr std::uint64_t kOwnMaps = std::uint64_t{1} << 32U;

/// The map of a graph to localize in.
Submap mapOf(const GraphRecord& record, const OccupancyGridConfig& grid) {
  if (record.keyframes.empty()) throw std::runtime_error("there is no map yet");
  return submapOf(mapKeyframes(record), grid);
}

}  // namespace

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
  if (!graph_ || localizing_) return result;
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

void SharedMapper::configure(const MapperConfig& config, const LoopConfig& loops,
                             bool keep_out_moving) {
  const Lock lock(mutex_);
  config_ = config;
  loops_ = loops;
  mapping_.configure(config);
  mapping_.keepOutMoving(keep_out_moving);
  if (graph_) graph_->configure(loops);
}

std::pair<MapperConfig, LoopConfig> SharedMapper::parameters() const {
  const Lock lock(mutex_);
  return {config_, loops_};
}

void SharedMapper::reset(const Pose2& map_T_base) {
  const Lock lock(mutex_);
  mapping_.reset(map_T_base);
  if (localizing_) return;
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
void SharedMapper::continueWith(GraphRecord record, const std::optional<GaussianPose2>& map_T_base,
                                bool localize) {
  requireGraph();
  const auto [config, loops] = parameters();
  std::unique_ptr<Localizer> localizer;
  if (localize) localizer = std::make_unique<Localizer>(config, mapOf(record, config.grid));
  auto graph = std::make_unique<SubmapGraph>(config, loops, std::move(record));
  auto map = std::make_unique<ComposedMap>(config.grid);
  map->add(*graph);
  if (!localize) graph->beginPart(map_T_base);
  const Lock lock(mutex_);
  localizing_ = localize;
  mapping_.localizeWith(std::move(localizer));
  if (!localize || map_T_base) mapping_.reset(map_T_base ? map_T_base->mean : Pose2());
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

void SharedMapper::waitForGraph() {
  if (graph_) graph_->snapshot();
}

void SharedMapper::localizeInGrown(GraphRecord record) {
  requireGraph();
  const auto [config, loops] = parameters();
  auto localizer = std::make_unique<Localizer>(config, mapOf(record, config.grid));
  std::optional<Pose2> moved;
  if (isLocalizing())
    moved = mapMotionAt(pose(), mapKeyframes(graph_->snapshot().record), mapKeyframes(record));
  auto graph = std::make_unique<SubmapGraph>(config, loops, std::move(record));
  auto map = std::make_unique<ComposedMap>(config.grid);
  map->add(*graph);
  const Lock lock(mutex_);
  if (moved && mapping_.localizer() != nullptr)
    localizer->continueFrom(*mapping_.localizer(), *moved);
  mapping_.localizeWith(std::move(localizer));
  localizing_ = true;
  graph_->replace(std::move(graph), std::move(map));
  ++map_number_;
  ++version_;
}

void SharedMapper::localizeIn(Submap map) {
  localizeWith(std::make_unique<Localizer>(parameters().first, std::move(map)));
}

void SharedMapper::localizeWith(std::unique_ptr<Localizer> localizer) {
  const Lock lock(mutex_);
  mapping_.localizeWith(std::move(localizer));
  localizing_ = true;
  memory_bytes_ = mapping_.mapper().memoryBytes();
  ++map_number_;
  ++version_;
}

Submap SharedMapper::presentMap() {
  const OccupancyGridConfig grid = parameters().first.grid;
  if (graph_) return mapOf(graph_->snapshot().record, grid);
  MapSnapshot picture;
  {
    const Lock lock(mutex_);
    picture = mapping_.mapper().snapshot();
  }
  if (picture.empty()) throw std::runtime_error("there is no map yet");
  return submapOf(picture, grid);
}

void SharedMapper::localize() {
  auto localizer = std::make_unique<Localizer>(parameters().first, presentMap());
  localizer->setPose(pose());
  localizeWith(std::move(localizer));
}

void SharedMapper::mapAgain() {
  std::unique_ptr<SubmapGraph> graph;
  std::unique_ptr<ComposedMap> map;
  if (graph_) {
    const auto [config, loops] = parameters();
    graph = std::make_unique<SubmapGraph>(config, loops, graph_->snapshot().record);
    map = std::make_unique<ComposedMap>(config.grid);
    map->add(*graph);
  }
  const Lock lock(mutex_);
  if (mapping_.localizer() == nullptr || mapping_.localizer()->isLost())
    throw std::runtime_error("the pose in the map is unknown; call relocalize or set initialpose");
  if (!graph && !mapping_.hasOwnMap())
    throw std::runtime_error("the map of map_file does not grow; load a session instead");
  const Pose2 pose = mapping_.mapper().pose();
  localizing_ = false;
  mapping_.mapAgain(pose);
  if (graph) {
    mapping_.reset(pose);
    graph->beginPart(givenStart(pose));
    graph_->replace(std::move(graph), std::move(map));
    graph_->configure(loops_);
  }
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
  if (graph_ && !localizing_) {
    result.complete = !graph_->takeChangedTiles(kTiles, result.tiles, result.map_number);
  } else {
    result.complete = !mapping_.takeChangedTiles(kTiles, result.tiles);
    result.map_number = kOwnMaps + map_number_;
  }
  result.stamp = stamp_;
  return result;
}

}  // namespace kestrel
