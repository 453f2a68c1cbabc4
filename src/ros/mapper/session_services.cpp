// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/session_services.h"

#include <ros/console.h>
#include <sys/resource.h>
#include <unistd.h>

#include <exception>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "kestrel_slam/graph/repeated_keyframes.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/parameters/parameters_yaml.h"
#include "kestrel_slam/session/graph_session.h"
#include "kestrel_slam/session/session_file.h"

namespace kestrel {
namespace {

constexpr char kExtension[] = ".session";
constexpr char kAutosave[] = "autosave.session", kOldAutosave[] = "autosave.old.session";
constexpr double kMaxDistanceM = 10000.0;
constexpr int kNice = 10;
constexpr double kSecondsPerMinute = 60.0, kFollowPeriod = 1.0;

Session sessionOf(const GraphSnapshot& graph, const SlamConfig& config) {
  const OccupancyGridConfig& grid = config.mapper.grid;
  Session session = sessionOf(withoutRepeated(graph.record, graph.loaded, grid), grid.resolution_m);
  session.parameters = parametersYaml(config);
  return session;
}

std::optional<GaussianPose2> startOf(const Session& session, const std::string& start,
                                     const Pose2& pose) {
  if (start.empty() || start == "last") return startAtEnd(session);
  if (start == "unknown") return std::nullopt;
  if (start == "pose" && pose.distance() > kMaxDistanceM)
    throw std::runtime_error("start_pose is more than 10 km from the origin of the map");
  if (start == "pose") return givenStart(pose);
  throw std::runtime_error("start is '" + start + "', but must be last, pose or unknown");
}

}  // namespace

SessionServices::SessionServices(const ros::NodeHandle& nh, const MapperNodeConfig& config,
                                 SharedMapper& mapper, std::function<void()> on_loaded)
    : config_(config),
      folder_(config.session_folder, {"sessions are only saved and loaded", "session_folder"}),
      mapper_(mapper),
      on_loaded_(std::move(on_loaded)),
      nh_(nh) {
  nh_.setCallbackQueue(&queue_);
  if (config_.follow_session) {
    mapper_.localizeIn(Submap(config_.slam.mapper.grid));  // until the file is there
    follow();
  } else if (!config_.session.empty() && !config_.localizesInPicture()) {
    const std::string start = config_.localizes() ? "unknown" : config_.session_start;
    try {
      ROS_INFO("%s", loadFrom(config_.session, start, Pose2(), config_.localizes()).c_str());
    } catch (const std::exception& error) {
      throw std::invalid_argument("parameter session: " + std::string(error.what()));
    }
  }
  advertise();
  spinner_ = std::make_unique<ros::AsyncSpinner>(1, &queue_);
  spinner_->start();
}

SessionServices::~SessionServices() { spinner_->stop(); }

void SessionServices::advertise() {
  save_server_ = nh_.advertiseService("save_session", &SessionServices::save, this);
  mode_server_ = nh_.advertiseService("set_mode", &SessionServices::setMode, this);
  load_server_ = nh_.advertiseService("load_session", &SessionServices::load, this);
  if (config_.follow_session) {
    follow_timer_ = nh_.createWallTimer(ros::WallDuration(kFollowPeriod),
                                        [this](const ros::WallTimerEvent&) { follow(); });
  }
  if (config_.autosave_minutes <= 0.0) return;
  if (mapper_.graph() == nullptr) {
    ROS_WARN("autosave_minutes has no effect: sessions need the parameter graph.");
    return;
  }
  timer_ = nh_.createWallTimer(ros::WallDuration(kSecondsPerMinute * config_.autosave_minutes),
                               [this](const ros::WallTimerEvent&) { autosave(); });
}

std::string SessionServices::fileOf(const std::string& path, bool to_save) const {
  if (mapper_.graph() == nullptr)
    throw std::runtime_error("there is no session: sessions need the parameter graph");
  std::string file = folder_.fileOf(path, to_save);
  const bool exists = std::filesystem::exists(file);
  if (std::filesystem::is_directory(file))
    throw std::runtime_error("'" + file + "' is a folder; give the name of a file");
  if (!to_save) {
    if (!exists && std::filesystem::exists(file + kExtension)) return file + kExtension;
    return file;
  }
  if (std::filesystem::path(file).extension().empty()) file += kExtension;
  if (std::filesystem::exists(file) && !isSessionFile(file))
    throw std::runtime_error("'" + file + "' exists and is no session; choose another name");
  return file;
}

std::string SessionServices::saveTo(const std::string& path) {
  const std::string file = fileOf(path, true);
  const GraphSnapshot graph = mapper_.graphSnapshot();
  Session session = sessionOf(graph, config_.slam);
  session.statistics = statistics_;
  addStatistic(session, "flights", 1.0);
  if (!session.keyframes.empty()) session.end = mapper_.pose();
  saveSession(file, session);
  return "saved " + std::to_string(session.keyframes.size()) + " keyframes to " + file;
}

std::string SessionServices::loadFrom(const std::string& path, const std::string& start,
                                      const Pose2& pose, bool localize) {
  Session session = loadSession(path);
  const std::optional<GaussianPose2> begin = startOf(session, start, pose);
  try {
    mapper_.continueWith(graphRecordOf(session, config_.slam.mapper.grid.resolution_m), begin,
                         localize);
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
  statistics_ = std::move(session.statistics);
  on_loaded_();
  return "loaded " + std::to_string(session.keyframes.size()) + " keyframes from " + path;
}

bool SessionServices::save(kestrel_slam::SaveSession::Request& request,
                           kestrel_slam::SaveSession::Response& response) {
  response.success = false;
  try {
    response.message = saveTo(request.path);
    response.success = true;
    ROS_INFO("save_session: %s", response.message.c_str());
  } catch (const std::exception& error) {
    response.message = error.what();
    ROS_ERROR("save_session: %s", error.what());
  }
  return true;  // the service call worked; the response contains the result
}

bool SessionServices::load(kestrel_slam::LoadSession::Request& request,
                           kestrel_slam::LoadSession::Response& response) {
  response.success = false;
  try {
    const Pose2 pose = request.start == "pose" ? planarFromMessage(request.start_pose) : Pose2();
    response.message =
        loadFrom(fileOf(request.path, false), request.start, pose, mapper_.isLocalizing());
    response.success = true;
    ROS_INFO("load_session: %s", response.message.c_str());
  } catch (const std::exception& error) {
    response.message = error.what();
    ROS_ERROR("load_session: %s", error.what());
  }
  return true;  // the service call worked; the response contains the result
}

bool SessionServices::setMode(kestrel_slam::SetMode::Request& request,
                              kestrel_slam::SetMode::Response& response) {
  response.success = false;
  try {
    response.message = changeTo(request.mode);
    response.success = true;
    ROS_INFO("set_mode: %s", response.message.c_str());
  } catch (const std::exception& error) {
    response.message = error.what();
    ROS_ERROR("set_mode: %s", error.what());
  }
  return true;  // the service call worked; the response contains the result
}

std::string SessionServices::changeTo(const std::string& mode) {
  if (mode != "mapping" && mode != "localization")
    throw std::runtime_error("mode is '" + mode + "', but must be mapping or localization");
  if (config_.slam.mapper.known_poses)
    throw std::runtime_error("with map_with_known_poses nothing is localized");
  const bool localize = mode == "localization";
  if (localize == mapper_.isLocalizing()) return "the mode was already " + mode;
  if (localize) {
    mapper_.localize();
    return "the vehicle is localized; the map does not change";
  }
  mapper_.mapAgain();
  return "the map grows";
}

/// Loads the session when its file is another one than the last time. The pose goes on: the file
/// is the same map, which has grown.
void SessionServices::follow() {
  std::error_code missing;
  const auto time = std::filesystem::last_write_time(config_.session, missing);
  if (missing || time == followed_) return;
  followed_ = time;
  try {
    Session session = loadSession(config_.session);
    removeUnplaced(session);
    const std::size_t count = session.keyframes.size();
    mapper_.localizeInGrown(graphRecordOf(session, config_.slam.mapper.grid.resolution_m));
    ROS_INFO("Localizing in %zu keyframes of %s", count, config_.session.c_str());
  } catch (const std::exception& error) {
    ROS_WARN("follow_session: %s is not used: %s", config_.session.c_str(), error.what());
  }
}

/// After a crash, somebody may have started a new map before the old one was loaded.
void SessionServices::keepOldAutosave() {
  if (saved_version_ != 0) return;
  const std::string file = fileOf(kAutosave, true);
  std::error_code ignored;
  if (!std::filesystem::exists(file) || std::filesystem::equivalent(file, config_.session, ignored))
    return;
  const std::string kept = fileOf(kOldAutosave, true);
  std::filesystem::rename(file, kept);
  ROS_WARN("%s was saved by an earlier run and is kept as %s.", file.c_str(), kept.c_str());
}

void SessionServices::autosave() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
  const std::uint64_t version = mapper_.version();
  if (mapper_.isLocalizing() || version == saved_version_ ||
      mapper_.graph()->view().keyframes.empty())
    return;
  try {
    keepOldAutosave();
    const std::string done = saveTo(kAutosave);  // ROS_DEBUG may leave its arguments out
    ROS_DEBUG("%s", done.c_str());
    saved_version_ = version;
  } catch (const std::exception& error) {
    ROS_ERROR("autosave: %s", error.what());
  }
}

}  // namespace kestrel
