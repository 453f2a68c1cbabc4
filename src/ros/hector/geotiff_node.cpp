// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/hector/geotiff_node.h"

#include <nav_msgs/GetMap.h>
#include <ros/console.h>

#include <array>
#include <ctime>
#include <filesystem>
#include <stdexcept>

#include "kestrel_slam/GetRobotTrajectory.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/ros/common/guarded.h"
#include "kestrel_slam/ros/common/private_parameters.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kQueue = 10;

/// The time of the day, as the rules of RoboCup Rescue want it in the name of the file.
std::string timeOfDay() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::array<char, 16> text{};
  std::strftime(text.data(), text.size(), "%H%M%S", &local);
  return text.data();
}

GeotiffMark::Kind kindOf(const std::string& name) {
  const auto has = [&](const char* part) { return name.find(part) != std::string::npos; };
  if (has("victim")) return GeotiffMark::Kind::kVictim;
  if (has("hazard")) return GeotiffMark::Kind::kHazard;
  if (has("qr")) return GeotiffMark::Kind::kQr;
  return GeotiffMark::Kind::kOther;
}

GeotiffMark markOf(const visualization_msgs::Marker& marker) {
  const geometry_msgs::Point& position = marker.pose.position;
  return {kindOf(marker.ns),
          {position.x, position.y},
          marker.text.empty() ? std::to_string(marker.id) : marker.text};
}

}  // namespace

std::vector<Parameter> parametersOf(GeotiffConfig& config) {
  using namespace parameter_table;
  constexpr double kLongest = 86400.0;
  return group(
      "GeoTIFF",
      {text("map_file_path", &config.map_file_path,
            "Folder of the files; a relative one counts from the working folder of the node."),
       text("map_file_base_name", &config.map_file_base_name,
            "Begin of the file name; the parameters /competition, /team and /mission and the "
            "time of the day follow."),
       text("map_file_postfix", &config.map_file_postfix,
            "Part of the file name before the time of the day."),
       number("geotiff_save_period", "s", &config.geotiff_save_period, 0.0, kLongest,
              "Time between two files; 0: only on request."),
       flag("draw_background_checkerboard", &config.draw_background_checkerboard,
            "Draw the unexplored area as a checkerboard of 1 m."),
       flag("draw_free_space_grid", &config.draw_free_space_grid,
            "Draw a grid of 0.5 m in the explored area.")});
}

GeotiffNode::GeotiffNode(ros::NodeHandle nh, const ros::NodeHandle& private_nh) : nh_(nh) {
  const UnneededParameters unneeded = {
      {"plugins", "the trajectory and the markers on geotiff_markers are always drawn"},
      {"use_map_topic", "the map comes from the service dynamic_map, or else from map"}};
  readPrivateParameters(private_nh, parametersOf(config_), unneeded);
  command_subscriber_ = subscribeGuarded<std_msgs::String>(
      nh, "syscommand", kQueue, [this](const std_msgs::String::ConstPtr& command) {
        if (command->data == "savegeotiff") writeAndLog();
        if (command->data == "reset") marks_.clear();
      });
  using visualization_msgs::MarkerArray;
  marker_subscriber_ = subscribeGuarded<MarkerArray>(
      nh, "geotiff_markers", kQueue,
      [this](const MarkerArray::ConstPtr& message) { onMarkers(*message); });
  save_server_ = nh_.advertiseService("save_geotiff", &GeotiffNode::save, this);
  if (config_.geotiff_save_period > 0.0) {
    timer_ = nh_.createTimer(ros::Duration(config_.geotiff_save_period),
                             [this](const ros::TimerEvent&) { writeAndLog(); });
  }
}

void GeotiffNode::onMarkers(const visualization_msgs::MarkerArray& message) {
  using visualization_msgs::Marker;
  for (const Marker& marker : message.markers) {
    if (marker.action == Marker::DELETEALL) {
      marks_.clear();
    } else if (marker.action == Marker::DELETE) {
      marks_.erase({marker.ns, marker.id});
    } else {
      marks_[{marker.ns, marker.id}] = markOf(marker);
    }
  }
}

bool GeotiffNode::save(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  try {
    response.message = write();
    response.success = true;
  } catch (const std::exception& error) {
    response.message = error.what();
    ROS_ERROR("save_geotiff: %s.", error.what());
  }
  return true;  // the service call worked; the response contains the result
}

void GeotiffNode::writeAndLog() {
  try {
    ROS_INFO("GeoTIFF written: %s", write().c_str());
  } catch (const std::exception& error) {
    ROS_ERROR("No GeoTIFF was written: %s.", error.what());
  }
}

std::string GeotiffNode::write() {
  GeotiffContent content;
  content.map = askForMap();
  content.path = askForPath();
  for (const auto& [name, mark] : marks_) content.marks.push_back(mark);
  content.checkerboard = config_.draw_background_checkerboard;
  content.grid = config_.draw_free_space_grid;
  const fs::path name = fs::path(config_.map_file_path) / fileName();
  content.title = name.filename().string() + ".tif";
  fs::create_directories(name.parent_path());
  writeGeotiff(name.string(), content);
  return fs::absolute(name).lexically_normal().string() + ".tif";
}

MapSnapshot GeotiffNode::askForMap() {
  nav_msgs::GetMap map;
  for (const char* service : {"dynamic_map", "map"}) {
    ros::ServiceClient client = nh_.serviceClient<nav_msgs::GetMap>(service);
    if (client.exists() && client.call(map)) return fromMessage(map.response.map);
  }
  throw std::runtime_error("there is no map: neither the service " +
                           nh_.resolveName("dynamic_map") + " nor " + nh_.resolveName("map") +
                           " gives one");
}

/// Without a trajectory there is still a map to be saved.
std::vector<Pose2> GeotiffNode::askForPath() {
  kestrel_slam::GetRobotTrajectory trajectory;
  ros::ServiceClient client = nh_.serviceClient<kestrel_slam::GetRobotTrajectory>("trajectory");
  if (!client.exists() || !client.call(trajectory)) {
    ROS_WARN("The GeoTIFF has no trajectory: the service %s does not give one.",
             client.getService().c_str());
  }
  std::vector<Pose2> path;
  for (const geometry_msgs::PoseStamped& pose : trajectory.response.trajectory.poses) {
    path.push_back(toPose2(pose.pose));
  }
  return path;
}

std::string GeotiffNode::fileName() const {
  std::string name = config_.map_file_base_name;
  const auto add = [&name](const std::string& part) {
    if (!part.empty()) name += (name.empty() ? "" : "_") + part;
  };
  for (const char* parameter : {"/competition", "/team", "/mission"}) {
    std::string part;
    if (nh_.getParam(parameter, part)) add(part);
  }
  add(config_.map_file_postfix);
  if (name.empty()) name = "GeoTiffMap";
  add(timeOfDay());
  return name;
}

}  // namespace kestrel
