// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "kestrel_slam/mapping/lost_watch.h"
#include "kestrel_slam/pipeline/mapping_stage.h"
#include "kestrel_slam/ros/common/fair_mutex.h"
#include "kestrel_slam/ros/mapper/graph_worker.h"

namespace kestrel {

/// A part of the changes of the map since they were last taken.
struct MapChanges {
  std::vector<TileImage> tiles;
  bool complete = false;         ///< nothing is left
  std::uint64_t map_number = 0;  ///< changes with each reset: the older tiles are not valid
  std::uint64_t version = 0;     ///< of the map; changes with the map
  ros::Time stamp;               ///< of the last scan that the mapper saw
};

/// The mapper with a lock, and its pose graph if it has one. All poses are in map: what the mapper
/// does in its local frame is corrected here. Besides the matching, no caller holds the lock for
/// more than some tens of microseconds.
class SharedMapper {
 public:
  explicit SharedMapper(const MapperConfig& config, const LoopConfig& loops = LoopConfig(),
                        bool keep_out_moving = false);

  MapperResult process(PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                       const ros::Time& stamp);

  /// Uses these parameters from the next scan on, see Mapper::configure, SubmapGraph::configure and
  /// MappingStage::keepOutMoving.
  void configure(const MapperConfig& config, const LoopConfig& loops, bool keep_out_moving);

  /// Deletes the map. The next scan starts a new map at `map_T_base`. While it localizes, the map
  /// stays and the vehicle is at `map_T_base`.
  void reset(const Pose2& map_T_base);

  /// Continues the graph of a session. The next scan begins a new part of it at `map_T_base`, see
  /// SubmapGraph::beginPart; or the vehicle is only localized in the map of the session. Throws
  /// std::runtime_error if there is no graph.
  void continueWith(GraphRecord record, const std::optional<GaussianPose2>& map_T_base,
                    bool localize = false);

  /// Localizes in the map of a session that is a newer one of the present map: the vehicle stays
  /// where it is, if its pose is known.
  void localizeInGrown(GraphRecord record);

  /// A copy of the graph. Throws std::runtime_error if there is none.
  GraphSnapshot graphSnapshot();
  /// Returns when the graph and its map have all scans that came before. Nothing without a graph.
  void waitForGraph();

  /// From now on the vehicle is only localized in this map, which does not change.
  void localizeIn(Submap map);
  /// The same in the present map, from the present pose on. Throws std::runtime_error if it is
  /// empty.
  void localize();
  /// Maps on. With a graph, this is a new part of it that begins where the vehicle is. Throws
  /// std::runtime_error if the pose is unknown, or if the map cannot grow.
  void mapAgain();
  bool isLocalizing() const { return localizing_; }
  /// Forgets the pose and searches the whole map. Returns false while it maps.
  bool relocalize();

  /// Keeps the map and sets the pose of the vehicle.
  void setPose(const Pose2& map_T_base);

  /// Keeps map and pose but resets the motion model. Used after a gap or a jump in time.
  void restartMotion();

  Pose2 pose() const;

  /// Takes some of the changed tiles. Call it until the result is complete. For one reader.
  MapChanges takeChanges();

  /// Changes when the map changes. Never blocks.
  std::uint64_t version() const { return version_ + (graph_ ? graph_->version() : 0); }

  /// The memory limit kept a part of the map out. Never blocks.
  bool isFull() const { return full_; }

  /// Memory of the map after the last scan. Never blocks.
  std::size_t memoryBytes() const { return memory_bytes_ + (graph_ ? graph_->memoryBytes() : 0); }

  /// Null if scans are matched against one map that grows.
  const GraphWorker* graph() const { return graph_.get(); }

 private:
  std::pair<MapperConfig, LoopConfig> parameters() const;
  void requireGraph() const;
  Pose2 mapTLocal() const {
    return graph_ && !localizing_ ? graph_->correction().map_T_local : Pose2();
  }
  void localizeWith(std::unique_ptr<Localizer> localizer);
  Submap presentMap();

  MapperConfig config_;
  LoopConfig loops_;
  mutable FairMutex mutex_;
  MappingStage mapping_;
  LostWatch lost_;
  std::unique_ptr<GraphWorker> graph_;
  ros::Time stamp_;
  std::uint64_t map_number_ = 1;
  std::atomic<bool> full_{false}, localizing_{false};
  std::atomic<std::uint64_t> version_{0};
  std::atomic<std::size_t> memory_bytes_{0};
};

}  // namespace kestrel
