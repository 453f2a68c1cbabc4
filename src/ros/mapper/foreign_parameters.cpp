// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/foreign_parameters.h"

#include <utility>
#include <vector>

namespace kestrel {
namespace {

/// A parameter of the other package and its name here.
const std::vector<std::pair<const char*, const char*>> kOtherNames = {
    // gmapping
    {"delta", "map_resolution"},
    {"maxUrange", "laser_max_dist"},
    {"maxRange", "clear_range"},
    {"linearUpdate", "map_update_distance_thresh"},
    {"angularUpdate", "map_update_angle_thresh"},
    {"tf_delay", "transform_tolerance"},
    {"minimumScore", "lost_score (0 to 1)"},
    // slam_toolbox
    {"resolution", "map_resolution"},
    {"max_laser_range", "laser_max_dist"},
    {"min_laser_range", "laser_min_dist"},
    {"minimum_travel_distance", "map_update_distance_thresh"},
    {"minimum_travel_heading", "map_update_angle_thresh"},
    {"map_update_interval", "map_pub_period"},
    {"transform_timeout", "transform_tolerance"},
    {"correlation_search_space_dimension", "search_window (half of the value)"},
    {"coarse_search_angle_offset", "search_angle"},
    {"scan_queue_size", "scan_subscriber_queue_size"}};

struct Group {
  const char* reason;
  std::vector<const char*> names;
};

const std::vector<Group> kWithoutCounterpart = {
    {"every scan is used, and tf is published with every scan",
     {"throttle_scans", "temporalUpdate", "transform_publish_period", "minimum_time_interval"}},
    {"the map has no fixed size, it grows", {"xmin", "ymin", "xmax", "ymax"}},
    {"there are no particles",
     {"particles", "resampleThreshold", "srr", "srt", "str", "stt", "llsamplerange", "llsamplestep",
      "lasamplerange", "lasamplestep"}},
    {"the matcher is another one; its parameters are in doc/ros_api.md",
     {"sigma",
      "kernelSize",
      "lstep",
      "astep",
      "iterations",
      "lsigma",
      "ogain",
      "lskip",
      "use_scan_matching",
      "use_scan_barycenter",
      "link_match_minimum_response_fine",
      "link_scan_maximum_distance",
      "correlation_search_space_resolution",
      "correlation_search_space_smear_deviation",
      "distance_variance_penalty",
      "angle_variance_penalty",
      "fine_search_angle_offset",
      "coarse_angle_resolution",
      "minimum_angle_penalty",
      "minimum_distance_penalty",
      "use_response_expansion"}},
    {"the map has the values -1, 0 and 100", {"occ_thresh"}},
    {"the covariance needs no factor", {"position_covariance_scale", "yaw_covariance_scale"}},
    {"there is no plugin and no Ceres here",
     {"solver_plugin", "ceres_linear_solver", "ceres_preconditioner", "ceres_trust_strategy",
      "ceres_dogleg_type", "ceres_loss_function"}},
    {"it belongs to slam_toolbox alone; see doc/migration.md",
     {"mode", "map_file_name", "map_start_pose", "map_start_at_dock", "debug_logging",
      "stack_size_to_use", "enable_interactive_mode", "tf_buffer_duration", "scan_buffer_size",
      "scan_buffer_maximum_scan_distance", "do_loop_closing", "loop_search_maximum_distance",
      "loop_match_minimum_chain_size", "loop_match_maximum_variance_coarse",
      "loop_match_minimum_response_coarse", "loop_match_minimum_response_fine",
      "loop_search_space_dimension", "loop_search_space_resolution",
      "loop_search_space_smear_deviation"}}};

}  // namespace

UnneededParameters foreignParameters() {
  UnneededParameters foreign;
  for (const auto& [theirs, ours] : kOtherNames) {
    foreign[theirs] = std::string("here it is called ") + ours;
  }
  for (const Group& group : kWithoutCounterpart) {
    for (const char* name : group.names) foreign[name] = group.reason;
  }
  return foreign;
}

}  // namespace kestrel
