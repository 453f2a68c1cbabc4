// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/mapper_node.h"

#include <pthread.h>
#include <ros/console.h>

#include <chrono>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <utility>

#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/planar_scan_message.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/pipeline/matched_pose.h"
#include "kestrel_slam/ros/common/guarded.h"
#include "kestrel_slam/ros/common/names.h"
#include "kestrel_slam/ros/common/wall_throttle.h"
#include "kestrel_slam/session/finished_map.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kCommandQueue = 10;
constexpr double kComplainEvery = 5.0;    // s
constexpr double kRemindEvery = 60.0;     // s; for problems that persist
constexpr double kMaxDistance = 10000.0;  // m; there float has a resolution of 1 mm

ProjectionStageConfig levelProjection(const MapperNodeConfig& config) {
  ProjectionStageConfig result;
  result.projector = config.slam.projector;
  result.level = true;
  return result;
}

/// What the node does, for the log.
std::string summaryOf(const MapperNodeConfig& config) {
  const std::string published = "tf is " + config.map_frame + " -> " +
                                (config.usesOdometry() ? config.odom_frame : config.base_frame);
  if (config.slam.mapper.known_poses) {
    return "nothing is matched: the poses are those of tf " + config.odom_frame + " -> " +
           config.base_frame;
  }
  return config.usesOdometry() ? published : "no odometry, " + published;
}

std::string textOf(const Pose2& pose) {
  char text[100];
  std::snprintf(text, sizeof text, "x %.2f m, y %.2f m, yaw %.3f rad", pose.x, pose.y, pose.yaw);
  return text;
}

/// A pose that a user sets. Throws std::invalid_argument with the reason if it cannot be used.
Pose2 placeFrom(const geometry_msgs::Pose& message) {
  const Pose2 pose = planarFromMessage(message);
  if (pose.distance() <= kMaxDistance) return pose;
  throw std::invalid_argument("the pose (" + textOf(pose) + ") is more than " +
                              std::to_string(std::lround(kMaxDistance)) +
                              " m from the origin of the map; use a local map frame");
}

}  // namespace

MapperNode::MapperNode(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : config_(loadParameters(private_nh)),
      mapper_(config_.slam.mapper, config_.slam.loops, config_.slam.tracker),
      queue_(static_cast<std::size_t>(config_.scan_subscriber_queue_size)),
      projection_(levelProjection(config_)),
      pose_publisher_(nh, config_),
      live_config_(config_) {
  command_subscriber_ = subscribeGuarded<std_msgs::String>(
      nh, config_.sys_msg_topic, kCommandQueue,
      [this](const std_msgs::StringConstPtr& message) { onCommand(*message); });
  using geometry_msgs::PoseWithCovarianceStamped;
  initial_pose_subscriber_ = subscribeGuarded<PoseWithCovarianceStamped>(
      nh, "initialpose", kCommandQueue,
      [this](const PoseWithCovarianceStamped::ConstPtr& message) { onInitialPose(*message); }, {},
      Stamps::kIgnored);
  reset_server_ = nh.advertiseService("reset_map", &MapperNode::resetMap, this);
  pause_server_ = nh.advertiseService("pause_mapping", &MapperNode::pauseMapping, this);
  restart_server_ =
      nh.advertiseService("restart_mapping_with_new_pose", &MapperNode::restartMapping, this);
  relocalize_server_ = nh.advertiseService("relocalize", &MapperNode::relocalize, this);
  if (config_.localizes()) localize();
  map_publisher_ = std::make_unique<MapPublisher>(nh, config_, mapper_, trajectory_);
  trajectory_services_ = std::make_unique<TrajectoryServices>(map_publisher_->nodeHandle(),
                                                              config_.map_frame, trajectory_);
  session_services_ =
      std::make_unique<SessionServices>(nh, config_, mapper_, [this] { onSession(); });
  input_ = std::make_unique<ScanInput>(nh, config_, statistics_,
                                       [this](ReadyScan scan) { enqueue(std::move(scan)); });
  diagnostics_ = std::make_unique<Diagnostics>(
      map_publisher_->nodeHandle(), private_nh, input_->neededTopic(), config_.inputParameter(),
      statistics_, [this] { return input_->publisherCount(); },
      [this] { return map_publisher_->mapSize(); }, [this] { return mapper_.isLocalizing(); });
  live_parameters_ = std::make_unique<LiveParameters>(private_nh, parametersOf(live_config_),
                                                      [this] { onParameters(); });
  map_thread_ = map_publisher_->thread();
  map_thread_->start();
  match_thread_ = std::thread([this] { matchLoop(); });
  pthread_setname_np(match_thread_.native_handle(), "match");
  ROS_INFO("%s scans on %s; %s.", config_.localizes() ? "Localizing with" : "Mapping",
           input_->topic().c_str(), summaryOf(config_).c_str());
}

MapperNode::~MapperNode() {
  session_services_.reset();
  queue_.close();
  match_thread_.join();
}

void MapperNode::enqueue(ReadyScan scan) {
  if (!queue_.push(std::move(scan))) statistics_.dropped("overload");
}

void MapperNode::matchLoop() {
  while (const std::optional<ReadyScan> scan = queue_.pop()) {
    try {
      handle(*scan);
    } catch (const std::exception& error) {
      statistics_.dropped("internal-error");
      KESTREL_ERROR_THROTTLE(kComplainEvery, "A scan was not matched: %s", error.what());
    }
  }
}

void MapperNode::handle(const ReadyScan& scan) {
  // What a user says during a pause must survive it: it replaces the old correction.
  if (placed_.exchange(false)) pose_publisher_.place(mapper_.pose(), scan.odom_T_base);
  if (statistics_.paused()) {
    was_paused_ = true;
    statistics_.dropped("paused");
    pose_publisher_.repeatCorrection(scan.stamp);
    return;
  }
  if (was_paused_ || scan.epoch != epoch_) continueAfter(scan);
  match(scan);
}

/// After a gap the motion model is not valid, but the odometry may still be.
void MapperNode::continueAfter(const ReadyScan& scan) {
  const bool same_epoch = scan.epoch == epoch_;
  was_paused_ = false;
  epoch_ = scan.epoch;
  const std::optional<Pose2> carried = pose_publisher_.poseByOdometry(scan.odom_T_base);
  if (same_epoch && carried) {
    mapper_.setPose(*carried);
  } else {
    mapper_.restartMotion();
  }
}

/// Throws std::invalid_argument if the parameters do not fit together.
void MapperNode::onParameters() {
  validate(live_config_.slam);
  map_publisher_->setPeriod(live_config_.map_pub_period);
  const std::lock_guard<std::mutex> lock(new_parameters_mutex_);
  new_parameters_ = live_config_.slam;
}

void MapperNode::takeParameters() {
  const std::lock_guard<std::mutex> lock(new_parameters_mutex_);
  if (!new_parameters_) return;
  mapper_.configure(new_parameters_->mapper, new_parameters_->loops, new_parameters_->tracker);
  projection_.configure(new_parameters_->projector);
  new_parameters_.reset();
}

void MapperNode::match(const ReadyScan& scan) {
  takeParameters();
  const auto start = std::chrono::steady_clock::now();
  std::optional<PlanarScan> planar = planarOf(scan);
  if (!planar) return;
  const MapperResult result = mapper_.process(*planar, scan.odom_T_base, scan.stamp);
  const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
  if (!result.pose.isFinite()) throw std::runtime_error("the pose is not finite");
  statistics_.used(result, ms.count());
  projection_.addVelocity(planar->stamp, knownVelocity(result), knownYawRate(result));
  trajectory_.add(scan.stamp, result.pose);
  pose_publisher_.publish(scan.stamp, result, *planar, scan.odom_T_base);
}

/// Empty if the scan cannot be used. The reason is counted and logged.
std::optional<PlanarScan> MapperNode::planarOf(const ReadyScan& scan) {
  if (scan.message.planar_scan) return planarOf(*scan.message.planar_scan);
  const LaserScan laser_scan = fromMessage(*scan.message.laser_scan);
  constexpr bool kLevel = true;
  Projection projection =
      projection_.project(laser_scan, scan.base_T_laser, kLevel, scan.odom_T_base).projection;
  if (!projection.warnings.empty()) {
    KESTREL_WARN_THROTTLE(kRemindEvery, "Scans on %s are used, but %s.", input_->topic().c_str(),
                          textOf(projection.warnings).c_str());
  }
  for (const ImuFault& problem : projection_.problems(laser_scan.stamp)) {
    if (said_.insert(problem.reason).second) ROS_WARN("%s.", problem.message.c_str());
  }
  if (projection.error == ScanError::kNone) return std::move(projection.scan);
  drop(toString(projection.error), projection.message);
  return std::nullopt;
}

std::optional<PlanarScan> MapperNode::planarOf(const kestrel_slam::PlanarScan& message) {
  try {
    PlanarScan scan = fromPlanarScanMessage(message);
    if (!scan.rays.empty()) return scan;
    drop(toString(ScanError::kNoBeams), "it has no rays");
  } catch (const std::invalid_argument& error) {
    drop("bad-planar-scan", error.what());
  }
  return std::nullopt;
}

void MapperNode::drop(const std::string& reason, const std::string& sentence) {
  statistics_.dropped(reason);
  KESTREL_WARN_THROTTLE(kComplainEvery, "A scan on %s is dropped (%s): %s.",
                        input_->topic().c_str(), reason.c_str(), sentence.c_str());
}

/// Returns what was done.
std::string MapperNode::restart(const Pose2& map_T_base) {
  queue_.clear();  // scans from before the command do not belong to the new map
  mapper_.reset(map_T_base);
  placed_ = true;
  trajectory_.clear();
  const std::string done = mapper_.isLocalizing() ? "the map is kept; the vehicle is at "
                                                  : "the map was deleted; the new one starts at ";
  ROS_INFO("Restarted: %s%s.", done.c_str(), textOf(map_T_base).c_str());
  return done + textOf(map_T_base);
}

/// Deletes the map. One to localize in is kept, and the pose is forgotten.
std::string MapperNode::reset() {
  if (mapper_.relocalize()) return "the map is kept; the pose is searched for in the whole map";
  restart(Pose2());
  return "the map was deleted";
}

/// The mapper continues another session.
void MapperNode::onSession() {
  queue_.clear();
  placed_ = true;
  trajectory_.clear();
}

void MapperNode::onCommand(const std_msgs::String& message) {
  if (message.data == "reset") reset();
}

void MapperNode::onInitialPose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  if (config_.slam.mapper.known_poses) {
    ROS_ERROR("initialpose is refused: with ~map_with_known_poses the pose comes from tf.");
    return;
  }
  const std::string& frame = message.header.frame_id;
  if (frame != config_.map_frame && frame != "/" + config_.map_frame) {
    ROS_ERROR("initialpose is refused: its frame is '%s', but must be '%s'.",
              clippedName(frame).c_str(), config_.map_frame.c_str());
    return;
  }
  try {
    const Pose2 pose = placeFrom(message.pose.pose);
    mapper_.setPose(pose);
    placed_ = true;
    ROS_INFO("The pose of the vehicle was set to %s.", textOf(pose).c_str());
  } catch (const std::invalid_argument& error) {
    ROS_ERROR("initialpose is refused: %s.", error.what());
  }
}

/// Localization starts with an unknown pose. The session services load a session.
void MapperNode::localize() {
  if (config_.map_file.empty() && config_.session.empty())
    throw std::invalid_argument("mode localization needs a map: set ~map_file or ~session");
  if (config_.map_file.empty()) return;
  try {
    mapper_.localizeIn(loadFinishedMap(config_.map_file, config_.slam.mapper.grid));
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(std::string("the map cannot be used: ") + error.what());
  }
}

bool MapperNode::relocalize(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  response.success = mapper_.relocalize();
  response.message = response.success ? "the pose is searched for in the whole map"
                                      : "it maps; call set_mode with mode localization first";
  return true;
}

bool MapperNode::resetMap(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  response.message = reset();
  response.success = true;
  return true;
}

bool MapperNode::pauseMapping(std_srvs::SetBool::Request& request,
                              std_srvs::SetBool::Response& response) {
  const bool changes = statistics_.paused() != static_cast<bool>(request.data);
  statistics_.setPaused(request.data);
  response.success = true;
  response.message = std::string(changes ? "mapping is now " : "mapping was already ") +
                     (request.data ? "paused" : "running");
  ROS_INFO("pause_mapping: %s.", response.message.c_str());
  return true;
}

bool MapperNode::restartMapping(kestrel_slam::ResetMapping::Request& request,
                                kestrel_slam::ResetMapping::Response& response) {
  response.success = false;
  try {
    const Pose2 pose = placeFrom(request.initial_pose);
    response.message = restart(pose);
    response.success = true;
  } catch (const std::invalid_argument& error) {
    response.message = error.what();
    ROS_ERROR("restart_mapping_with_new_pose is refused: %s.", error.what());
  }
  return true;  // the service call worked; the response contains the result
}

}  // namespace kestrel
