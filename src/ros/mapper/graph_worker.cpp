// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/graph_worker.h"

#include <pthread.h>
#include <sys/resource.h>

#include <utility>

#include "kestrel_slam/graph/submap_graph.h"

namespace kestrel {
namespace {

/// The matching comes first.
constexpr int kNice = 10;

}  // namespace

GraphWorker::GraphWorker(const MapperConfig& mapper, const LoopConfig& loops)
    : mapper_(mapper), loops_(loops) {
  start();
  thread_ = std::thread([this] { run(); });
  pthread_setname_np(thread_.native_handle(), "graph");
}

GraphWorker::~GraphWorker() {
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    closed_ = true;
  }
  arrived_.notify_one();
  thread_.join();
}

void GraphWorker::add(const PlanarScan& scan, const MapperResult& result) {
  if (!result.inserted) return;
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    queue_.push_back({scan, result});
  }
  arrived_.notify_one();
}

void GraphWorker::configure(const LoopConfig& loops) {
  const std::lock_guard<std::mutex> lock(queue_mutex_);
  new_loops_ = loops;
}

void GraphWorker::reset() {
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    queue_.clear();
    reset_ = true;
    map_T_local_ = Pose2();
    view_ = {};
  }
  arrived_.notify_one();
}

void GraphWorker::run() {
  setpriority(PRIO_PROCESS, 0, kNice);  // of this thread
  for (;;) {
    std::unique_lock<std::mutex> lock(queue_mutex_);
    arrived_.wait(lock, [this] { return closed_ || reset_ || !queue_.empty(); });
    if (closed_) return;
    takeParameters();
    if (std::exchange(reset_, false)) {
      lock.unlock();
      start();
      continue;
    }
    const Work work = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    handle(work);
  }
}

/// The caller holds the lock of the queue.
void GraphWorker::takeParameters() {
  if (!new_loops_) return;
  loops_ = *std::exchange(new_loops_, std::nullopt);
  graph_->configure(loops_);
}

/// Begins an empty graph and map.
void GraphWorker::start() {
  graph_ = std::make_unique<SubmapGraph>(mapper_, loops_);
  const std::lock_guard<FairMutex> lock(map_mutex_);
  map_ = std::make_unique<ComposedMap>(mapper_.grid);
  ++map_number_;
  ++version_;
}

void GraphWorker::handle(const Work& work) {
  graph_->add(work.scan, work.result);
  if (map_->isOutdated(*graph_)) {
    auto composed = std::make_unique<ComposedMap>(mapper_.grid);
    composed->add(*graph_);
    const std::lock_guard<FairMutex> lock(map_mutex_);
    map_ = std::move(composed);
    ++map_number_;
  } else {
    const std::lock_guard<FairMutex> lock(map_mutex_);
    map_->add(*graph_);
  }
  memory_bytes_ = graph_->memoryBytes() + map_->grid().memoryBytes();
  GraphView view;
  for (std::size_t i = 0; i < graph_->keyframes().size(); ++i)
    view.keyframes.push_back(graph_->poseOf(i));
  view.loops = graph_->loops();
  const std::lock_guard<std::mutex> lock(queue_mutex_);
  if (reset_) return;
  map_T_local_ = graph_->mapTLocal();
  view_ = std::move(view);
  ++version_;
}

Pose2 GraphWorker::mapTLocal() const {
  const std::lock_guard<std::mutex> lock(queue_mutex_);
  return map_T_local_;
}

GraphView GraphWorker::view() const {
  const std::lock_guard<std::mutex> lock(queue_mutex_);
  return view_;
}

bool GraphWorker::takeChangedTiles(std::size_t max_tiles, std::vector<TileImage>& images,
                                   std::uint64_t& map_number) {
  const std::lock_guard<FairMutex> lock(map_mutex_);
  map_number = map_number_;
  return map_->grid().takeChangedTiles(max_tiles, images);
}

}  // namespace kestrel
