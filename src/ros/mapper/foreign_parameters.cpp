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
    {"scan_queue_size", "scan_subscriber_queue_size"},
    {"do_loop_closing", "graph (and close_loops)"},
    {"loop_search_space_dimension", "loop_search_window (half of the value)"},
    {"loop_match_minimum_response_fine", "loop_min_fit"},
    {"map_file_name", "map_file (YAML file of a map, not of a pose graph; or session)"},
    // cartographer_ros
    {"published_frame", "base_frame (or odom_frame)"},
    {"tracking_frame", "base_frame"},
    {"lookup_transform_timeout_sec", "transform_tolerance"}};

struct Group {
  const char* reason;
  std::vector<const char*> names;
};

const std::vector<Group> kWithoutCounterpart = {
    {"every scan is used, and tf is published with every scan",
     {"throttle_scans", "temporalUpdate", "transform_publish_period", "minimum_time_interval",
      "rangefinder_sampling_ratio", "submap_publish_period_sec", "pose_publish_period_sec",
      "trajectory_publish_period_sec"}},
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
    {"the map has the values -1, 0 and 100; probability_map has 0 to 100", {"occ_thresh"}},
    {"the covariance needs no factor", {"position_covariance_scale", "yaw_covariance_scale"}},
    {"the optimizer of the pose graph has no such choices",
     {"solver_plugin", "ceres_linear_solver", "ceres_preconditioner", "ceres_trust_strategy",
      "ceres_dogleg_type", "ceres_loss_function"}},
    {"the mounting of the laser, also upside down, is taken from tf", {"inverted_laser"}},
    {"the odometry is used whenever odom_frame is set",
     {"use_odometry", "odometry_sampling_ratio", "provide_odom_frame"}},
    {"scan_projector_node takes several lasers, clouds and the IMU (mav.launch)",
     {"num_laser_scans", "num_multi_echo_laser_scans", "num_subdivisions_per_laser_scan",
      "num_point_clouds", "imu_sampling_ratio", "use_imu_data"}},
    {"the pose filter takes GPS (fix_topic); there are no landmarks",
     {"use_nav_sat", "use_landmarks", "fixed_frame_pose_sampling_ratio",
      "landmarks_sampling_ratio"}},
    {"pose and tf are always published, in the plane",
     {"publish_frame_projected_to_2d", "publish_tracked_pose", "publish_to_tf",
      "use_pose_extrapolator", "restamp_tf"}},
    {"the vehicle is searched for in the whole map; initialpose sets its place",
     {"map_start_pose", "map_start_at_dock"}},
    {"nothing is removed from the pose graph",
     {"lifelong_search_use_tree", "lifelong_minimum_score", "lifelong_iou_match",
      "lifelong_node_removal_score", "lifelong_overlap_score_scale",
      "lifelong_constraint_multiplier", "lifelong_nearby_penalty", "lifelong_candidates_scale"}},
    {"only slam_toolbox has this; see doc/migration.md",
     {"debug_logging", "stack_size_to_use", "enable_interactive_mode", "interactive_mode",
      "first_map_only", "paused_new_measurements", "localization_on_configure",
      "do_final_optimization", "tf_buffer_duration", "scan_buffer_size",
      "scan_buffer_maximum_scan_distance", "loop_search_maximum_distance",
      "loop_match_minimum_chain_size", "loop_match_maximum_variance_coarse",
      "loop_match_minimum_response_coarse", "loop_search_space_resolution",
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
