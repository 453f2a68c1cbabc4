// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/LoadSession.h"
#include "kestrel_slam/SaveSession.h"
#include "kestrel_slam/SetMode.h"
#include "kestrel_slam/ros/mapper/mapper_parameters.h"
#include "kestrel_slam/ros/mapper/save_folder.h"
#include "kestrel_slam/ros/mapper/shared_mapper.h"
#include "kestrel_slam/session/session.h"

namespace kestrel {

/// Saves and loads sessions, by service and every ~autosave_minutes, and changes between mapping
/// and localization. All of it happens in a thread of its own, one after the other; neither scans
/// nor the matching wait for it.
class SessionServices {
 public:
  /// Loads the parameter ~session if there is one. `on_loaded`: the mapper continues another
  /// session. Throws std::invalid_argument if the session cannot be loaded.
  SessionServices(const ros::NodeHandle& nh, const MapperNodeConfig& config, SharedMapper& mapper,
                  std::function<void()> on_loaded);
  ~SessionServices();
  SessionServices(const SessionServices&) = delete;
  SessionServices& operator=(const SessionServices&) = delete;

 private:
  void advertise();
  bool save(kestrel_slam::SaveSession::Request& request,
            kestrel_slam::SaveSession::Response& response);
  bool load(kestrel_slam::LoadSession::Request& request,
            kestrel_slam::LoadSession::Response& response);
  bool setMode(kestrel_slam::SetMode::Request& request, kestrel_slam::SetMode::Response& response);
  std::string changeTo(const std::string& mode);
  void autosave();
  void follow();
  void keepOldAutosave();
  std::string saveTo(const std::string& path);
  std::string loadFrom(const std::string& path, const std::string& start, const Pose2& pose,
                       bool localize);
  std::string fileOf(const std::string& path, bool to_save) const;

  const MapperNodeConfig config_;
  SaveFolder folder_;
  SharedMapper& mapper_;
  std::function<void()> on_loaded_;
  std::vector<NamedNumber> statistics_;         ///< of the session that was loaded
  std::uint64_t saved_version_ = 0;             ///< of the map, by autosave
  std::filesystem::file_time_type followed_{};  ///< time of the file that was loaded last

  ros::NodeHandle nh_;
  ros::CallbackQueue queue_;
  ros::ServiceServer save_server_, load_server_, mode_server_;
  ros::WallTimer timer_, follow_timer_;
  std::unique_ptr<ros::AsyncSpinner> spinner_;
};

}  // namespace kestrel
