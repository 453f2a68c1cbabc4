// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "kestrel_slam/graph/composed_map.h"
#include "kestrel_slam/graph/loop.h"
#include "kestrel_slam/graph/submap_graph.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/ros/common/fair_mutex.h"

namespace kestrel {

/// Keyframes and loops as they are now, for publishing.
struct GraphView {
  std::vector<Pose2> keyframes;    ///< map_T_base
  std::vector<std::size_t> parts;  ///< of each keyframe, see connectedParts()
  /// Pairs of keyframes between which the vehicle moved.
  std::vector<std::pair<std::size_t, std::size_t>> path;
  std::vector<KnownPlace> submaps;
  std::vector<Loop> loops;
};

/// A copy of the graph, to save it.
struct GraphSnapshot {
  GraphRecord record;
  std::size_t loaded = 0;  ///< SubmapGraph::loadedCount
};

/// The pose graph in a thread of its own: the matching thread only hands over the inserted scans
/// and never waits. The thread also composes the map.
class GraphWorker {
 public:
  GraphWorker(const MapperConfig& mapper, const LoopConfig& loops);
  ~GraphWorker();
  GraphWorker(const GraphWorker&) = delete;
  GraphWorker& operator=(const GraphWorker&) = delete;

  /// Takes the scan if the mapper inserted it. `result.pose` is in the local frame. Must be called
  /// for every scan: the correction by a scan is used kCorrectionDelay scans later, so that the
  /// poses do not depend on how fast the thread is, as long as it needs less time.
  void add(const PlanarScan& scan, const MapperResult& result);

  /// The scans from now on are of a new part at an unknown place, see SubmapGraph::beginPart.
  void beginPart();

  /// See SubmapGraph::configure. Does not wait for a search that runs.
  void configure(const LoopConfig& loops);

  /// Deletes the graph and the map.
  void reset();

  /// Goes on with another graph and its map.
  void replace(std::unique_ptr<SubmapGraph> graph, std::unique_ptr<ComposedMap> map);

  /// Waits until the scans that were added before are in the graph, which may take some seconds.
  GraphSnapshot snapshot();

  static constexpr std::uint64_t kCorrectionDelay = 20;  ///< scans: 0.5 s at 40 Hz

  /// The correction of the local frame for the next scan.
  GraphCorrection correction() const;

  /// See OccupancyGrid::takeChangedTiles. For one reader. `map_number`: another one means that the
  /// map was composed again, and that the older tiles are not valid.
  bool takeChangedTiles(std::size_t max_tiles, std::vector<TileImage>& images,
                        std::uint64_t& map_number);

  GraphView view() const;

  /// Changes when the map changes. Never blocks.
  std::uint64_t version() const { return version_; }
  std::size_t memoryBytes() const { return memory_bytes_; }

 private:
  struct Work {
    PlanarScan scan;
    MapperResult result;
    bool begins_part = false;                             ///< and has no scan
    std::shared_ptr<std::promise<GraphSnapshot>> wanted;  ///< asks for a snapshot, has no scan
    std::uint64_t number = 0;                             ///< of the scan
  };
  struct LaterCorrection {
    std::uint64_t number;  ///< of the scan from which on it is used
    GraphCorrection correction;
  };

  void run();
  bool isIdle() const;
  void handle(const Work& work);
  bool isTimeToCompose() const;
  GraphCorrection correctionNow();
  void change(std::unique_ptr<SubmapGraph> graph);
  void compose();

  MapperConfig mapper_;
  mutable std::mutex queue_mutex_;  ///< for the queue, and what is asked for often
  std::condition_variable arrived_;
  std::deque<Work> queue_;
  LoopConfig loops_;
  bool closed_ = false, reconfigured_ = false;
  std::unique_ptr<SubmapGraph> next_graph_;  ///< replaces `graph_`
  GraphCorrection correction_;
  std::deque<LaterCorrection> later_;
  std::uint64_t scans_ = 0;        ///< that were added
  std::size_t waiting_parts_ = 0;  ///< in the queue: `correction_` is that of the last one
  GraphView view_;

  FairMutex map_mutex_;
  std::unique_ptr<ComposedMap> map_;
  bool is_new_map_ = false;  ///< `map_` belongs to `next_graph_`
  std::uint64_t map_number_ = 1;

  std::unique_ptr<SubmapGraph> graph_;  ///< only the thread uses it
  std::size_t uncomposed_ = 0;          ///< keyframes since the map was composed
  std::size_t solutions_ = 0;           ///< SubmapGraph::solutionCount() of `known_`
  std::optional<GraphCorrection::Known> known_;
  std::atomic<std::uint64_t> version_{0};
  std::atomic<std::size_t> memory_bytes_{0};
  std::thread thread_;
};

}  // namespace kestrel
