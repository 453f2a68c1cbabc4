// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <std_msgs/String.h>
#include <std_srvs/Trigger.h>
#include <visualization_msgs/MarkerArray.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"
#include "kestrel_slam/report/geotiff.h"

namespace kestrel {

struct GeotiffConfig {
  std::string map_file_path = ".";
  std::string map_file_base_name;
  std::string map_file_postfix;
  double geotiff_save_period = 0.0;  ///< s; 0: only when asked
  bool draw_background_checkerboard = true;
  bool draw_free_space_grid = true;
};
std::vector<Parameter> parametersOf(GeotiffConfig& config);

/// Draws map, trajectory and markers into a GeoTIFF, with the interface of hector_geotiff.
class GeotiffNode {
 public:
  GeotiffNode(ros::NodeHandle nh, const ros::NodeHandle& private_nh);

 private:
  void onMarkers(const visualization_msgs::MarkerArray& message);
  bool save(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  /// Writes the file and returns its path. Throws std::runtime_error.
  std::string write();
  void writeAndLog();
  MapSnapshot askForMap();
  std::vector<Pose2> askForPath();
  std::string fileName() const;

  GeotiffConfig config_;
  ros::NodeHandle nh_;
  std::map<std::pair<std::string, int>, GeotiffMark> marks_;  ///< by namespace and id
  ros::Subscriber command_subscriber_, marker_subscriber_;
  ros::ServiceServer save_server_;
  ros::Timer timer_;
};

}  // namespace kestrel
