// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {
namespace {

using namespace parameter_table;

std::vector<Parameter> mapParametersOf(MapperConfig& mapper) {
  OccupancyGridConfig& grid = mapper.grid;
  return {
      number("map_resolution", "m", &grid.resolution_m, 0.005, 1.0,
             "Edge length of a map cell; larger cells need less memory, and show less detail. With "
             "the graph, scans are matched in cells of at most 0.05 m."),
      number("update_factor_free", "", &grid.miss_probability, 0.01, 0.49,
             "Probability that a cell is occupied although a beam passed through it; a larger "
             "value clears occupied cells more slowly."),
      number("update_factor_occupied", "", &grid.hit_probability, 0.51, 0.99,
             "Probability that a cell is occupied if a beam ended in it; a larger value fills "
             "cells faster."),
      number("map_min_probability", "", &grid.min_probability, 0.0001, 0.49,
             "Lowest occupancy probability that a cell can have; a larger value lets free cells "
             "become occupied faster."),
      number("map_max_probability", "", &grid.max_probability, 0.51, 0.9999,
             "Highest occupancy probability that a cell can have; a larger value keeps walls for "
             "longer after they are gone."),
      number("map_memory_limit_mb", "MB", &grid.memory_limit_mb, 1.0, 1e6,
             "Memory at which the map stops growing; the mapper then warns and goes on."),
      live(number("map_update_distance_thresh", "m", &mapper.insert_distance_m, 0.0, kNoLimit,
                  "Distance from the last inserted scan at which the next one is inserted into the "
                  "map; a larger value inserts fewer scans.")),
      live(
          number("map_update_angle_thresh", "rad", &mapper.insert_angle_rad, 0.0, kNoLimit,
                 "Rotation since the last inserted scan at which the next one is inserted into the "
                 "map; above 3.15 a rotation alone never inserts a scan.")),
      flag("map_with_known_poses", &mapper.known_poses,
           "Take the pose of each scan from the odometry instead of matching it, and close no "
           "loops; mapper_node without odom_frame takes it from map_frame -> base_frame in tf."),
  };
}

std::vector<Parameter> matchingParametersOf(MapperConfig& mapper) {
  MatcherConfig& matcher = mapper.matcher;
  return {
      choice("matcher", &matcher.method, matcherNames(),
             "Method that finds the pose of a scan; hybrid is the one to fly with."),
      choice("covariance", &matcher.covariance, {"hessian", "sampled"},
             "Source of the match covariance: the Hessian at the pose, or the fit at 18 poses "
             "around it; matcher correlative has its own."),
      number("match_iterations", "", &matcher.gauss_newton.max_iterations, 1.0, 1000.0,
             "Largest number of Gauss-Newton iterations in each stage of the matching."),
      live(number(
          "good_score", "", &matcher.good_score, 0.0, 1.0,
          "Score below which other initial guesses are tried; a larger value tries them more "
          "often and needs more time.")),
      live(number(
          "search_score", "", &matcher.search_score, 0.0, 1.0,
          "Score below which a match is degraded and a wider search may start; a larger value "
          "searches more often and needs more time.")),
      live(number(
          "lost_score", "", &mapper.lost_score, 0.0, 1.0,
          "Score below which the mapper is lost and does not insert the scan; a larger value "
          "makes it lost earlier.")),
  };
}

std::vector<Parameter> searchParametersOf(MatcherConfig& matcher) {
  SearchWindow &near = matcher.near_window, &wide = matcher.wide_window;
  return {
      number("search_window", "m", &near.linear_m, 0.0, 10.0,
             "Half width in x and y of the first search; a larger window finds larger errors of "
             "the prediction and needs more time."),
      number("search_angle", "rad", &near.angular_rad, 0.0, 3.15,
             "Half width in yaw of the first search; a larger window finds larger errors of the "
             "prediction and needs more time."),
      number("wide_search_window", "m", &wide.linear_m, 0.0, 10.0,
             "Half width in x and y of the second search, which runs if the first one finds no "
             "good match."),
      number("wide_search_angle", "rad", &wide.angular_rad, 0.0, 3.15,
             "Half width in yaw of the second search, which runs if the first one finds no good "
             "match."),
  };
}

std::vector<Parameter> evaluationParametersOf(EvaluationConfig& evaluation) {
  return {
      live(flag("use_evaluation_function", &evaluation.enabled,
                "Insert only scans whose penalized evaluation is below evaluation_threshold.")),
      live(
          number("evaluation_threshold", "", &evaluation.threshold, 1.0, 1000.0,
                 "Evaluation above which a scan is not inserted; a larger value also inserts scans "
                 "that match less well.")),
      live(number("evaluation_penalty", "", &evaluation.penalty, 0.0, 1000.0,
                  "Weight of the pose differences between the map resolutions in the evaluation; a "
                  "larger value inserts fewer scans.")),
  };
}

std::vector<Parameter> graphParametersOf(WindowConfig& window, LoopConfig& loops) {
  return {
      flag("graph", &window.enabled,
           "Match against the last submaps only, and correct the map with a pose graph when a loop "
           "closes; false: one map that grows."),
      number("submap_scans", "", &window.submap_scans, 5.0, 1e6, "Inserted scans in a submap."),
      number("submap_overlap", "", &window.overlap_scans, 1.0, 1e6,
             "Last scans of a submap that the next one is matched against at its beginning; less "
             "than submap_scans."),
      number("submap_degenerate_weight", "", &window.degenerate_weight, 0.01, 1.0,
             "How much an inserted scan with an unobservable direction counts for the length of a "
             "submap; a smaller value keeps more of a corridor."),
      live(flag("close_loops", &loops.enabled,
                "Search for loops; false: the map is not corrected from then on.")),
      live(number(
          "loop_search_window", "m", &loops.wide_radius_m, 0.5, 50.0,
          "Half width in x and y of the search for a loop, in which the place must be unique; a "
          "larger window finds larger errors and needs more time.")),
      live(number("loop_min_fit", "", &loops.min_fit, 0.0, 1.0,
                  "Smallest score of the scans at a place that was visited before.")),
      live(
          number("loop_min_margin", "", &loops.min_margin, 0.0, 1.0,
                 "By how much this score must be better than anywhere else in the search window; a "
                 "larger value refuses more loops as ambiguous.")),
  };
}

std::vector<Parameter> candidateParametersOf(ProgressiveConfig& progressive) {
  return {
      number("progressive_seed", "", &progressive.seed, 0.0, kNoLimit,
             "Seed of the random candidate poses; the same seed gives the same result."),
      number("progressive_coarse_candidates", "", &progressive.coarse_candidates, 1.0, 1e6,
             "Number of candidate poses on the coarsest level; more candidates need more time."),
      number("progressive_fine_candidates", "", &progressive.fine_candidates, 1.0, 1e6,
             "Number of candidate poses on each finer level; more candidates need more time."),
      number("progressive_wide_candidates", "", &progressive.wide_candidates, 1.0, 1e6,
             "Number of candidate poses if none near the prediction matches."),
      number("progressive_motion_share", "", &progressive.motion_share, 0.0, 10.0,
             "Standard deviation of the candidates' position, as a share of the motion since the "
             "last scan; a larger value covers larger prediction errors."),
      number("progressive_turn_share", "", &progressive.turn_share, 0.0, 10.0,
             "Standard deviation of the candidates' yaw, as a share of the rotation since the "
             "last scan; a larger value covers larger prediction errors."),
      number("progressive_min_sigma", "m", &progressive.min_sigma_m, 0.001, 10.0,
             "Smallest standard deviation of the candidates' position."),
      number("progressive_min_sigma_angle", "rad", &progressive.min_sigma_rad, 0.001, 3.15,
             "Smallest standard deviation of the candidates' yaw."),
  };
}

std::vector<Parameter> refinementParametersOf(ProgressiveConfig& progressive) {
  return {
      number("progressive_shrink", "", &progressive.shrink, 0.01, 1.0,
             "Factor between the standard deviations of one level and of the coarser level; a "
             "smaller value searches the finer levels more narrowly."),
      number("progressive_slack", "cells", &progressive.slack_cells, 0.0, 100.0,
             "Correction, in cells of the coarser level, that never stops the refinement; 0: the "
             "rule as it is in [Xie 2010]."),
      number("progressive_beams", "", &progressive.beams, 1.0, 1e6,
             "Weight of the scan against the motion model; with a larger value the scan counts "
             "more."),
  };
}

std::vector<Parameter> icpParametersOf(IcpConfig& icp) {
  return {
      choice("icp_metric", &icp.metric, {"point_to_point", "point_to_line"},
             "Distance that is minimized: from a hit to its partner, or to the wall through the "
             "partner."),
      choice("icp_reference", &icp.reference, {"map", "last_scans"},
             "Points that a scan is paired with: occupied points of the map, or hits of the last "
             "inserted scans."),
      number("icp_last_scans", "", &icp.last_scans, 1.0, 1000.0,
             "Number of scans used with icp_reference last_scans; more scans need more time."),
      number("icp_rejected_share", "", &icp.rejected_share, 0.0, 0.9,
             "Share of the pairs, those with the largest distances, that is not used; a larger "
             "value rejects more outliers and more correct pairs."),
      number("icp_max_pair_distance", "m", &icp.max_pair_distance_m, 0.01, 10.0,
             "Largest distance between the two points of a pair in the first stage; the next two "
             "stages use 40 % and 20 % of it."),
      number("icp_iterations", "", &icp.max_iterations, 1.0, 1000.0,
             "Largest number of iterations in each stage."),
      number("icp_min_step", "m", &icp.min_step_m, 0.0, 1.0,
             "A stage ends when a step is shorter than this and its rotation below "
             "icp_min_angle."),
      number("icp_min_angle", "rad", &icp.min_step_rad, 0.0, 1.0,
             "A stage ends when a step rotates less than this and is shorter than icp_min_step."),
      flag("icp_stitching", &icp.stitching,
           "Insert only the hits that have no map point near them."),
  };
}

}  // namespace

std::vector<Parameter> mappingParametersOf(SlamConfig& config) {
  MatcherConfig& matcher = config.mapper.matcher;
  std::vector<Parameter> tracker = {
      live(flag("tracker", &config.tracker,
                "Track people and vehicles, and keep the beams on them out of matching and map."))};
  return joined({group("Map", mapParametersOf(config.mapper)),
                 group("Matching", matchingParametersOf(config.mapper)),
                 group("Matching: search", searchParametersOf(matcher)),
                 group("Evaluation of a match", evaluationParametersOf(config.mapper.evaluation)),
                 group("What moves", tracker),
                 group("Pose graph", graphParametersOf(config.mapper.window, config.loops)),
                 group("Matcher progressive", candidateParametersOf(matcher.progressive)),
                 group("Matcher progressive", refinementParametersOf(matcher.progressive)),
                 group("Matcher icp", icpParametersOf(matcher.icp))});
}

std::vector<Parameter> parametersOf(SlamConfig& config) {
  return joined(
      {mappingParametersOf(config), projectionParametersOf(config), attitudeParametersOf(config)});
}

}  // namespace kestrel
