// SPDX-License-Identifier: BSD-3-Clause
#include <iterator>

#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {
namespace {

using namespace parameter_table;

std::vector<Parameter> mapperParametersOf(MapperConfig& mapper) {
  OccupancyGridConfig& grid = mapper.grid;
  ProgressiveConfig& progressive = mapper.matcher.progressive;
  return {
      number("map_resolution", "m", &grid.resolution_m, 0.005, 1.0, "edge length of a map cell"),
      number("update_factor_free", "", &grid.miss_probability, 0.01, 0.49,
             "probability that a cell is occupied although a beam passed it"),
      number("update_factor_occupied", "", &grid.hit_probability, 0.51, 0.99,
             "probability that a cell is occupied where a beam ended in it"),
      number("map_min_probability", "", &grid.min_probability, 0.0001, 0.49,
             "lower clamp: how sure a cell can become that it is free"),
      number("map_max_probability", "", &grid.max_probability, 0.51, 0.9999,
             "upper clamp: how sure a cell can become that it is occupied"),
      number("map_memory_limit_mb", "MB", &grid.memory_limit_mb, 1.0, 1e6,
             "the map stops growing at this size, with a warning"),
      number("map_update_distance_thresh", "m", &mapper.insert_distance_m, 0.0, 100.0,
             "a scan enters the map after this much motion"),
      number("map_update_angle_thresh", "rad", &mapper.insert_angle_rad, 0.0, 100.0,
             "a scan enters the map after this much rotation"),
      number("lost_score", "", &mapper.lost_score, 0.0, 1.0,
             "a scan whose best fit is below this is lost and not inserted"),
      number("search_score", "", &mapper.matcher.search_score, 0.0, 1.0,
             "a fit below this is degraded and starts the exhaustive search"),
      number("good_score", "", &mapper.matcher.good_score, 0.0, 1.0,
             "a fit below this is compared with that from other starts"),
      number("search_window", "m", &mapper.matcher.near_window.linear_m, 0.0, 10.0,
             "the exhaustive search looks this far in x and y"),
      number("search_angle", "rad", &mapper.matcher.near_window.angular_rad, 0.0, 3.15,
             "the exhaustive search looks this far in yaw"),
      number("wide_search_window", "m", &mapper.matcher.wide_window.linear_m, 0.0, 10.0,
             "where that finds nothing good: this far in x and y"),
      number("wide_search_angle", "rad", &mapper.matcher.wide_window.angular_rad, 0.0, 3.15,
             "where that finds nothing good: this far in yaw"),
      number("match_iterations", "", &mapper.matcher.gauss_newton.max_iterations, 1.0, 1000.0,
             "Gauss-Newton iterations of each resolution at most"),
      number("progressive_seed", "", &progressive.seed, 0.0, 1e9,
             "of the candidates of matcher progressive: the same seed, the same result"),
      number("progressive_coarse_candidates", "", &progressive.coarse_candidates, 1.0, 1e6,
             "poses it tries on the coarsest level"),
      number("progressive_fine_candidates", "", &progressive.fine_candidates, 1.0, 1e6,
             "poses it tries on each finer level"),
      number("progressive_wide_candidates", "", &progressive.wide_candidates, 1.0, 1e6,
             "poses it tries where nothing near the prediction fits"),
      number("progressive_motion_share", "", &progressive.motion_share, 0.0, 10.0,
             "its sigma of the position, in shares of the motion since the last scan"),
      number("progressive_turn_share", "", &progressive.turn_share, 0.0, 10.0,
             "its sigma of the yaw, in shares of the turn since the last scan"),
      number("progressive_min_sigma", "m", &progressive.min_sigma_m, 0.001, 10.0,
             "its smallest sigma of the position"),
      number("progressive_min_sigma_angle", "rad", &progressive.min_sigma_rad, 0.001, 3.15,
             "its smallest sigma of the yaw"),
      number("progressive_shrink", "", &progressive.shrink, 0.01, 1.0,
             "sigmas of a level, in shares of those of the coarser level"),
      number("progressive_slack", "cells", &progressive.slack_cells, 0.0, 100.0,
             "a correction up to so many cells of the coarser level never stops it; 0: paper 002"),
      number("progressive_beams", "", &progressive.beams, 1.0, 1e6,
             "what a scan that fits is worth against the motion model, in units of log likelihood"),
      flag("use_evaluation_function", &mapper.evaluation.enabled,
           "judge by the penalized evaluation function whether a scan may enter the map"),
      number("evaluation_threshold", "", &mapper.evaluation.threshold, 1.0, 1000.0,
             "scans whose evaluation is above this stay out of the map"),
      number("evaluation_penalty", "", &mapper.evaluation.penalty, 0.0, 1000.0,
             "weight of the disagreement between the resolutions in the evaluation"),
      choice("matcher", &mapper.matcher.method, matcherNames(), "how the pose of a scan is found"),
      choice("covariance", &mapper.matcher.covariance, {"hessian", "sampled"},
             "of a match: from the Hessian at the pose, or from the fit at 18 poses around it"),
  };
}

std::vector<Parameter> icpParametersOf(IcpConfig& icp) {
  return {
      choice("icp_metric", &icp.metric, {"point_to_point", "point_to_line"},
             "icp: the distance of a hit to its partner, or to the wall through it"),
      choice("icp_reference", &icp.reference, {"map", "last_scans"},
             "icp: where the partners are: occupied points of the map, or hits of the last scans"),
      number("icp_last_scans", "", &icp.last_scans, 1.0, 1000.0,
             "icp: so many of the last inserted scans"),
      number("icp_rejected_share", "", &icp.rejected_share, 0.0, 0.9,
             "icp: share of the pairs, the worst, that do not count"),
      number("icp_max_pair_distance", "m", &icp.max_pair_distance_m, 0.01, 10.0,
             "icp: partners are at most this far away"),
      number("icp_iterations", "", &icp.max_iterations, 1.0, 1000.0,
             "icp: iterations of each stage at most"),
      number("icp_min_step", "m", &icp.min_step_m, 0.0, 1.0,
             "icp: a stage ends when the vehicle is moved by less than this,"),
      number("icp_min_angle", "rad", &icp.min_step_rad, 0.0, 1.0, "icp: and turned by less"),
      flag("icp_stitching", &icp.stitching,
           "icp: only hits that have no point of the map beside them enter it"),
  };
}

}  // namespace

std::vector<Parameter> projectorParametersOf(SlamConfig& config) {
  ProjectorConfig& projector = config.projector;
  BeamFilterConfig& beams = projector.beams;
  AttitudeConfig& attitude = config.attitude;
  return {
      number("laser_min_dist", "m", &beams.min_range_m, 0.0, 100.0,
             "closer returns are ignored: the vehicle itself"),
      number("laser_max_dist", "m", &beams.max_range_m, 0.1, 1000.0,
             "farther returns only clear free space"),
      number("clear_range", "m", &beams.clear_range_m, 0.0, 1000.0,
             "a beam without a return clears free space up to here; 0: not at all"),
      number("max_beams", "", &beams.max_beams, 1.0, 1e7, "scans with more beams are refused"),
      number("laser_z_min_value", "m", &projector.slice_min_m, -100.0, 0.0,
             "end points lower than this, relative to the laser, are not mapped"),
      number("laser_z_max_value", "m", &projector.slice_max_m, 0.0, 100.0,
             "end points higher than this, relative to the laser, are not mapped"),
      number("max_tilt", "rad", &projector.max_tilt_rad, 0.0, 1.5,
             "scans of a vehicle tilted farther are dropped"),
      number("floor_margin", "m", &projector.floor_margin_m, 0.0, 10.0,
             "end points closer to the floor or the ceiling than this are not mapped"),
      number("height", "m", &projector.height_m, 0.0, 1000.0,
             "of the base over the floor where nothing measures it; 0: unknown"),
      number("ceiling_height", "m", &projector.ceiling_m, 0.0, 1000.0,
             "of the ceiling over the floor; 0: unknown"),
      number("vehicle_radius", "m", &projector.vehicle_radius_m, 0.0, 10.0,
             "end points closer to the base than this are the vehicle's own frame; 0: none"),
      text(
          "ignored_angles", &projector.ignored_angles,
          "beams that meet the vehicle's frame: from:to, from:to in degrees, in the laser's frame"),
      text("mirror_angles", &projector.mirror_angles,
           "beams that a mirror bends down to measure the height: from:to, from:to in degrees"),
      text("range_correction", &projector.range_correction,
           "what a 2D laser measures too little: range:meters, range:meters, linear between"),
      number("mirror_distance", "m", &projector.mirror_distance_m, 0.0, 1.0,
             "from the laser to the mirror"),
      number("mixed_pixel_jump", "m", &projector.mixed_pixel_jump_m, 0.0, 10.0,
             "a beam between two jumps of range this large is not mapped; 0: off"),
      number("azimuth_bins", "", &projector.azimuth_bins, 8.0, 100000.0,
             "directions in the slice of a 3D lidar"),
      choice("attitude_source", &attitude.source, {"auto", "orientation", "raw"},
             "of the IMU: its orientation, or gyro and accelerometer; auto: what it gives"),
      number("attitude_max_gap", "s", &attitude.buffer.max_gap_s, 0.001, 10.0,
             "longest time between two IMU messages that is interpolated"),
      number("gravity_time", "s", &attitude.gravity_time_s, 0.01, 1000.0,
             "raw: time constant with which gravity corrects the gyro"),
      number("gravity_gate", "", &attitude.gravity_gate, 0.0, 1.0,
             "raw: share by which the acceleration may differ from gravity to be used"),
      number("gyro_bias_time", "s", &attitude.bias_time_s, 0.1, 1e6,
             "raw: time constant of the estimate of the gyro's bias"),
      number("imu_frozen_time", "s", &attitude.frozen_s, 0.01, 1000.0,
             "identical IMU messages for this long are not used"),
      number("imu_silent_time", "s", &attitude.silent_s, 0.01, 1000.0,
             "after this long without a message the IMU is silent"),
  };
}

std::vector<Parameter> parametersOf(SlamConfig& config) {
  std::vector<Parameter> all = mapperParametersOf(config.mapper);
  const auto append = [&all](std::vector<Parameter> more) {
    all.insert(all.end(), std::make_move_iterator(more.begin()),
               std::make_move_iterator(more.end()));
  };
  append(icpParametersOf(config.mapper.matcher.icp));
  append(projectorParametersOf(config));
  return all;
}

}  // namespace kestrel
