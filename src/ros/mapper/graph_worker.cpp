// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/graph_worker.h"

#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <utility>

#include "kestrel_slam/graph/submap_graph.h"

namespace kestrel {
namespace {

/// The matching comes first.
constexpr int kNice = 10;
/// A large map needs seconds to be composed, so the keyframes that wait come first. But the map
/// does not wait for more than so many.
constexpr std::size_t kMostUncomposed = 20;

GraphView viewOf(const SubmapGraph& graph) {
  GraphView view;
  for (std::size_t i = 0; i < graph.keyframes().size(); ++i)
    view.keyframes.push_back(graph.poseOf(i));
  view.parts = connectedParts(graph.graph());
  for (const PoseEdge& edge : graph.graph().edges)
    if (edge.kind == EdgeKind::kOdometry) view.path.emplace_back(edge.from, edge.to);
  view.submaps = graph.places().all();
  view.loops = graph.loops();
  return view;
}

}  // namespace

GraphWorker::GraphWorker(const MapperConfig& mapper, const LoopConfig& loops)
    : mapper_(mapper), loops_(loops) {
  reset();
  change(std::move(next_graph_));
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
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    ++scans_;
    for (; !later_.empty() && later_.front().number <= scans_; later_.pop_front())
      correction_ = std::move(later_.front().correction);
    if (!result.inserted) return;
    queue_.push_back({scan, result, false, nullptr, scans_});
  }
  arrived_.notify_one();
}

void GraphWorker::beginPart() {
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    correction_ = {Pose2(), std::nullopt, false};
    later_.clear();
    ++waiting_parts_;
    queue_.push_back({{}, {}, true, nullptr, scans_});
  }
  arrived_.notify_one();
}

void GraphWorker::configure(const LoopConfig& loops) {
  const std::lock_guard<std::mutex> lock(queue_mutex_);
  loops_ = loops;
  reconfigured_ = true;
}

void GraphWorker::reset() {
  replace(std::make_unique<SubmapGraph>(mapper_, loops_),
          std::make_unique<ComposedMap>(mapper_.grid));
}

void GraphWorker::replace(std::unique_ptr<SubmapGraph> graph, std::unique_ptr<ComposedMap> map) {
  {
    const std::lock_guard<FairMutex> map_lock(map_mutex_);
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    queue_.erase(std::remove_if(queue_.begin(), queue_.end(),
                                [](const Work& work) { return work.wanted == nullptr; }),
                 queue_.end());
    waiting_parts_ = 0;
    correction_ = {graph->mapTLocal(), std::nullopt, graph->isLocated()};
    later_.clear();
    view_ = {};
    next_graph_ = std::move(graph);
    map_ = std::move(map);
    is_new_map_ = true;
    ++map_number_;
    ++version_;
  }
  arrived_.notify_one();
}

GraphSnapshot GraphWorker::snapshot() {
  const auto wanted = std::make_shared<std::promise<GraphSnapshot>>();
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    queue_.push_back({{}, {}, false, wanted, scans_});
  }
  arrived_.notify_one();
  return wanted->get_future().get();
}

/// The caller holds the lock.
bool GraphWorker::isIdle() const { return !closed_ && !next_graph_ && queue_.empty(); }

void GraphWorker::run() {
  setpriority(PRIO_PROCESS, 0, kNice);  // of this thread
  for (;;) {
    std::unique_lock<std::mutex> lock(queue_mutex_);
    arrived_.wait(lock, [this] { return !isIdle(); });
    if (closed_) return;
    if (std::exchange(reconfigured_, false)) {
      graph_->configure(loops_);
      if (next_graph_) next_graph_->configure(loops_);
    }
    if (next_graph_) {
      std::unique_ptr<SubmapGraph> graph = std::move(next_graph_);
      lock.unlock();
      change(std::move(graph));
    } else {
      const Work work = std::move(queue_.front());
      queue_.pop_front();
      lock.unlock();
      handle(work);
      if (isTimeToCompose()) compose();
    }
  }
}

/// The new graph, whose map is already there.
void GraphWorker::change(std::unique_ptr<SubmapGraph> graph) {
  graph_ = std::move(graph);
  solutions_ = graph_->solutionCount();
  known_.reset();
  uncomposed_ = 0;
  const std::lock_guard<FairMutex> lock(map_mutex_);
  is_new_map_ = false;
  memory_bytes_ = graph_->memoryBytes() + map_->grid().memoryBytes();
}

/// Adds what is new in the graph to the map, or composes the map again. Not if the map already
/// belongs to the next graph.
void GraphWorker::compose() {
  const auto is_outdated = [this] {
    const std::lock_guard<FairMutex> lock(map_mutex_);
    return !is_new_map_ && map_->isOutdated(*graph_);
  };
  std::unique_ptr<ComposedMap> composed;
  if (is_outdated()) {
    composed = std::make_unique<ComposedMap>(mapper_.grid);
    composed->add(*graph_);
  }
  const std::lock_guard<FairMutex> lock(map_mutex_);
  if (is_new_map_) return;
  if (composed) {
    map_ = std::move(composed);
    ++map_number_;
  } else {
    map_->add(*graph_);
  }
  memory_bytes_ = graph_->memoryBytes() + map_->grid().memoryBytes();
  uncomposed_ = 0;
  ++version_;
}

void GraphWorker::handle(const Work& work) {
  if (work.wanted) {
    if (uncomposed_ > 0) compose();
    return work.wanted->set_value({graph_->record(), graph_->loadedCount()});
  }
  if (work.begins_part) {
    graph_->beginPart(std::nullopt);
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    if (waiting_parts_ > 0) --waiting_parts_;
    return;
  }
  graph_->add(work.scan, work.result);
  ++uncomposed_;
  GraphView view = viewOf(*graph_);
  GraphCorrection correction = correctionNow();
  const std::lock_guard<std::mutex> lock(queue_mutex_);
  if (next_graph_) return;
  if (waiting_parts_ == 0)
    later_.push_back({work.number + kCorrectionDelay, std::move(correction)});
  view_ = std::move(view);
}

bool GraphWorker::isTimeToCompose() const {
  const std::lock_guard<std::mutex> lock(queue_mutex_);
  return uncomposed_ > 0 && (queue_.empty() || uncomposed_ >= kMostUncomposed);
}

/// The covariance needs a factorization, so it is only computed where the graph was optimized.
GraphCorrection GraphWorker::correctionNow() {
  const std::size_t solutions = graph_->solutionCount();
  if (std::exchange(solutions_, solutions) != solutions) known_ = graph_->knownEnd();
  return {graph_->mapTLocal(), known_, graph_->isLocated()};
}

GraphCorrection GraphWorker::correction() const {
  const std::lock_guard<std::mutex> lock(queue_mutex_);
  return correction_;
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
