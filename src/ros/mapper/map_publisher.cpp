// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/map_publisher.h"

#include <map_msgs/OccupancyGridUpdate.h>
#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Path.h>
#include <ros/console.h>
#include <sys/resource.h>
#include <unistd.h>

#include <exception>
#include <utility>

#include "kestrel_slam/map/map_io.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/ros/common/wall_throttle.h"
#include "kestrel_slam/ros/mapper/graph_markers.h"

namespace kestrel {
namespace {

constexpr double kTick = 0.1;              // s; longest delay until a new subscriber gets the map
constexpr double kUpdatePeriod = 0.5;      // s
constexpr double kTrajectoryPeriod = 0.5;  // s
constexpr double kComplainEvery = 10.0;    // s
constexpr std::uint32_t kQueueSize = 1;    // only the newest message matters
constexpr int kNice = 10;                  // about a tenth of the CPU time of another thread

/// Lowers the priority of this thread, so that poses have priority if all threads share one core.
/// On Linux a nice value applies to one thread.
void stepBehindOtherThreads() { setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice); }

LoopCounts countsOf(const std::vector<Loop>& loops) {
  LoopCounts counts;
  for (const Loop& loop : loops) {
    counts.closed += loop.state == LoopState::kAccepted;
    counts.refused += loop.state == LoopState::kRefused || loop.state == LoopState::kUndone;
  }
  return counts;
}

}  // namespace

MapPublisher::MapPublisher(const ros::NodeHandle& nh, const MapperNodeConfig& config,
                           SharedMapper& mapper, TrajectoryLog& trajectory)
    : nh_(nh),
      map_frame_(config.map_frame),
      with_map_service_(config.advertise_map_service),
      period_s_(config.map_pub_period),
      save_folder_(config.save_folder),
      mapper_(mapper),
      trajectory_(trajectory),
      replica_(config.slam.mapper.grid.resolution_m) {
  nh_.setCallbackQueue(&queue_);
  last_info_.resolution = static_cast<float>(config.slam.mapper.grid.resolution_m);
  advertise();
  timer_ =
      nh_.createWallTimer(ros::WallDuration(kTick), [this](const ros::WallTimerEvent&) { tick(); });
}

void MapPublisher::advertise() {
  const auto connected = [this](const ros::SingleSubscriberPublisher&) { new_subscriber_ = true; };
  map_publisher_ = nh_.advertise<nav_msgs::OccupancyGrid>(
      "map", kQueueSize, connected, ros::SubscriberStatusCallback(), ros::VoidConstPtr(), true);
  probability_publisher_ = nh_.advertise<nav_msgs::OccupancyGrid>(
      "probability_map", kQueueSize,
      [this](const ros::SingleSubscriberPublisher&) { wants_probabilities_ = true; },
      ros::SubscriberStatusCallback(), ros::VoidConstPtr(), true);
  update_publisher_ = nh_.advertise<map_msgs::OccupancyGridUpdate>("map_updates", kQueueSize);
  metadata_publisher_ = nh_.advertise<nav_msgs::MapMetaData>("map_metadata", kQueueSize, true);
  trajectory_publisher_ = nh_.advertise<nav_msgs::Path>("trajectory", kQueueSize, true);
  if (mapper_.graph() != nullptr) {
    using visualization_msgs::MarkerArray;
    graph_publisher_ = nh_.advertise<MarkerArray>("graph_markers", kQueueSize, true);
    loop_publisher_ = nh_.advertise<MarkerArray>("loop_closures", kQueueSize, true);
    submap_publisher_ = nh_.advertise<MarkerArray>("submaps", kQueueSize, true);
  }
  if (with_map_service_) {
    map_server_ = nh_.advertiseService("dynamic_map", &MapPublisher::dynamicMap, this);
  }
  save_server_ = nh_.advertiseService("save_map", &MapPublisher::saveMap, this);
}

void MapPublisher::tick() {
  if (!stands_behind_) stepBehindOtherThreads();
  stands_behind_ = true;
  try {
    warnOfFullMap();
    publishMap();
    if (wants_probabilities_) publishProbabilities();
    publishUpdate();
    publishTrajectory();
    publishGraph();
  } catch (const std::exception& error) {
    KESTREL_ERROR_THROTTLE(kComplainEvery, "The map was not published: %s", error.what());
  }
}

/// The first map is always published immediately. Later maps are published only if there are
/// subscribers.
void MapPublisher::publishMap() {
  const ros::WallTime now = ros::WallTime::now();
  const bool unchanged = mapper_.version() == published_version_;
  const bool unheard = published_version_ != 0 && !isHeard();
  if (unchanged || unheard || (now < next_map_ && !new_subscriber_)) return;
  refresh();
  if (replica_.known().empty()) return;  // after a reset: many clients cannot handle an empty map
  new_subscriber_ = false;
  next_map_ = now + ros::WallDuration(period_s_);
  published_version_ = version_;
  replica_.takeChanged();
  published_known_ = replica_.known();
  const nav_msgs::OccupancyGrid map = message(replica_.snapshot());
  map_publisher_.publish(map);
  metadata_publisher_.publish(map.info);
  if (probability_publisher_.getNumSubscribers() > 0) publishProbabilities();
}

void MapPublisher::publishProbabilities() {
  if (replica_.known().empty()) return;
  wants_probabilities_ = false;
  probability_publisher_.publish(message(replica_.probabilities()));
}

bool MapPublisher::isHeard() const {
  return map_publisher_.getNumSubscribers() + metadata_publisher_.getNumSubscribers() +
             probability_publisher_.getNumSubscribers() >
         0;
}

/// Copies the changed tiles, some at a time, so that the matching never waits long.
void MapPublisher::refresh() {
  for (bool complete = false; !complete;) {
    const MapChanges changes = mapper_.takeChanges();
    if (changes.map_number != map_number_) replica_.beginMap();
    map_number_ = changes.map_number;
    version_ = changes.version;
    stamp_ = changes.stamp;
    for (const TileImage& tile : changes.tiles) replica_.update(tile);
    complete = changes.complete;
  }
  replica_.endMap();
}

/// Publishes the part that changed since the last map or update, as long as the map has the same
/// size and origin; otherwise clients need the next whole map.
void MapPublisher::publishUpdate() {
  const ros::WallTime now = ros::WallTime::now();
  if (now < next_update_ || update_publisher_.getNumSubscribers() == 0) return;
  next_update_ = now + ros::WallDuration(kUpdatePeriod);
  refresh();
  if (!hasGeometryOfLastMap()) return;
  const CellRectangle changed = replica_.takeChanged();
  if (changed.empty()) return;
  map_msgs::OccupancyGridUpdate update;
  update.header.frame_id = map_frame_;
  update.header.stamp = stamp_;
  update.x = changed.x0 - published_known_.x0;
  update.y = changed.y0 - published_known_.y0;
  update.width = static_cast<std::uint32_t>(changed.x1 - changed.x0);
  update.height = static_cast<std::uint32_t>(changed.y1 - changed.y0);
  update.data = replica_.valuesIn(changed);
  update_publisher_.publish(update);
}

bool MapPublisher::hasGeometryOfLastMap() const {
  const CellRectangle &now = replica_.known(), &then = published_known_;
  return !now.empty() && now.x0 == then.x0 && now.y0 == then.y0 && now.x1 == then.x1 &&
         now.y1 == then.y1;
}

void MapPublisher::warnOfFullMap() {
  const bool is_full = mapper_.isFull();
  if (is_full && !warned_of_full_map_) {
    ROS_WARN(
        "The map is full: it does not grow any more, and new places are not mapped. Raise "
        "map_memory_limit_mb or map_resolution.");
  }
  warned_of_full_map_ = is_full;
}

void MapPublisher::publishTrajectory() {
  const ros::WallTime now = ros::WallTime::now();
  const std::uint64_t version = trajectory_.version();
  if (now < next_trajectory_ || version == published_trajectory_) return;
  if (trajectory_publisher_.getNumSubscribers() == 0) return;
  next_trajectory_ = now + ros::WallDuration(kTrajectoryPeriod);
  published_trajectory_ = version;
  trajectory_publisher_.publish(trajectory_.path(map_frame_));
}

void MapPublisher::publishGraph() {
  const GraphWorker* graph = mapper_.graph();
  const ros::WallTime now = ros::WallTime::now();
  if (graph == nullptr || now < next_graph_ || graph->version() == published_graph_) return;
  next_graph_ = now + ros::WallDuration(kTrajectoryPeriod);
  published_graph_ = graph->version();
  const GraphView view = graph->view();
  loops_ = countsOf(view.loops);
  graph_publisher_.publish(graphMarkers(view, map_frame_, stamp_));
  loop_publisher_.publish(loopMarkers(view, map_frame_, stamp_));
  submap_publisher_.publish(submapMarkers(view, map_frame_, stamp_));
}

/// `map`: of `replica_`.
nav_msgs::OccupancyGrid MapPublisher::message(MapSnapshot map) {
  nav_msgs::OccupancyGrid message = toMessage(std::move(map));
  message.header.frame_id = map_frame_;
  message.header.stamp = stamp_;
  message.info.map_load_time = stamp_;
  last_info_ = message.info;
  return message;
}

bool MapPublisher::dynamicMap(nav_msgs::GetMap::Request&, nav_msgs::GetMap::Response& response) {
  try {
    refresh();
    if (!replica_.known().empty()) {
      response.map = message(replica_.snapshot());
      return true;
    }
    ROS_WARN("dynamic_map: there is no map yet because no scan has been inserted.");
  } catch (const std::exception& error) {
    ROS_ERROR("dynamic_map: %s", error.what());
  }
  return false;
}

bool MapPublisher::saveMap(kestrel_slam::SaveMap::Request& request,
                           kestrel_slam::SaveMap::Response& response) {
  response.success = false;
  try {
    const std::string stem = save_folder_.stemOf(request.path);
    mapper_.waitForGraph();  // all scans that came before are in the map
    refresh();
    writeMap(stem, replica_.snapshot());
    response.success = true;
    response.message = "wrote " + stem + ".pgm and " + stem + ".yaml";
    ROS_INFO("save_map: %s", response.message.c_str());
  } catch (const std::exception& error) {
    response.message = error.what();
    ROS_ERROR("save_map: %s", error.what());
  }
  return true;  // the service call worked; the response contains the result
}

MapSize MapPublisher::mapSize() const {
  return {static_cast<int>(last_info_.width), static_cast<int>(last_info_.height),
          static_cast<double>(last_info_.resolution), mapper_.memoryBytes(), loops_};
}

}  // namespace kestrel
