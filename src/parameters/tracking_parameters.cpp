// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/parameters/tracking_parameters.h"

#include "kestrel_slam/parameters/parameter_table.h"

namespace kestrel {
namespace {

using namespace parameter_table;

std::vector<Parameter> gridParametersOf(MotionGridConfig& grid) {
  return {
      number("grid_resolution", "m", &grid.resolution_m, 0.02, 1.0,
             "Size of a cell; smaller cells show slower motion and need more time."),
      number("low", "", &grid.low, 0.01, 0.49,
             "Probability that a cell is occupied after a beam has passed it; smaller: what was "
             "left becomes free sooner."),
      number("medium", "", &grid.medium, 0.51, 0.99,
             "The same after a return from something that moves; larger: what stops becomes a part "
             "of the static grid sooner."),
      number("high", "", &grid.high, 0.51, 0.99,
             "The same after a return from something that stands; larger: walls resist beams that "
             "pass them because of errors."),
      number("wall_tolerance", "m", &grid.tolerance_m, 0.0, 1.0,
             "A return this near to something static belongs to it; larger for a poor pose."),
      number("wall_tolerance_angle", "rad", &grid.tolerance_rad, 0.0, 0.1,
             "Added to wall_tolerance for each meter of range; larger for a poor yaw."),
      number("new_time", "s", &grid.new_s, 0.0, 10.0,
             "What is seen in unknown space may move for this time, then it is static."),
      number("stopped_time", "s", &grid.stopped_s, 1.0, 3600.0,
             "What has stopped belongs to the static grid after this time; so a wall that was "
             "wrongly kept out comes back."),
      number("keep_radius", "m", &grid.keep_radius_m, 5.0, 1000.0,
             "The grids forget what is farther from the vehicle."),
  };
}

std::vector<Parameter> objectParametersOf(TrackerConfig& config) {
  return {
      number("bandwidth", "m", &config.bandwidth_m, 0.05, 5.0,
             "Bandwidth of the mean shift: about the distance of the legs of a person."),
      number("join_gap", "m", &config.join_gap_m, 0.0, 5.0,
             "Points with gaps up to this are one object."),
      number("min_width", "m", &config.min_width_m, 0.0, 5.0,
             "Width of the narrowest object; larger suppresses small ones."),
      number("coast_time", "s", &config.coast_s, 0.1, 60.0,
             "A visible object that gives no return is forgotten after this time."),
      number("hidden_time", "s", &config.hidden_s, 0.1, 60.0,
             "An object that is hidden is forgotten after this time."),
      number("moved_distance", "m", &config.moved_m, 0.0, 10.0,
             "An object is shown when it has moved by more than this and by more than half of its "
             "size."),
      number("motion_significance", "", &config.motion_significance, 1.0, 100.0,
             "An object is shown when its velocity is this many standard deviations; larger: fewer "
             "false tracks, later."),
      number("acceleration_sigma", "m/s²", &config.acceleration_sigma, 0.01, 100.0,
             "How much objects change their velocity."),
  };
}

}  // namespace

std::vector<Parameter> parametersOf(TrackerConfig& config) {
  return joined({group("Static and dynamic grid", gridParametersOf(config.grid)),
                 group("Objects", objectParametersOf(config))});
}

}  // namespace kestrel
