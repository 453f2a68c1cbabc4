// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {
namespace {

using namespace parameter_table;

std::vector<Parameter> beamParametersOf(ProjectorConfig& projector) {
  BeamFilterConfig& beams = projector.beams;
  return {
      live(number("laser_min_dist", "m", &beams.min_range_m, 0.0, 100.0,
                  "Shorter ranges are ignored: they are returns from the vehicle itself.")),
      live(number("laser_max_dist", "m", &beams.max_range_m, 0.1, 1000.0,
                  "Longer ranges count as no return: they clear free space and mark no wall.")),
      live(number("clear_range", "m", &beams.clear_range_m, 0.0, 1000.0,
                  "Distance up to which a beam without a return clears free space; 0: it clears "
                  "nothing.")),
      number("max_beams", "", &beams.max_beams, 1.0, 1e7, "Scans with more beams are dropped."),
      live(text("ignored_angles", &projector.ignored_angles,
                "Beams that hit the vehicle and are ignored: 'from:to, from:to' in degrees in the "
                "laser's frame, in quotes.")),
      live(number("vehicle_radius", "m", &projector.vehicle_radius_m, 0.0, 10.0,
                  "End points closer to the base than this are parts of the vehicle and are not "
                  "mapped; 0: off.")),
      live(flag("find_vehicle", &projector.find_vehicle,
                "Beams of a 2D laser that keep a range below 1 m while most of the view changes "
                "hit parts of the vehicle, and are ignored.")),
      live(number("mixed_pixel_jump", "m", &projector.mixed_pixel_jump_m, 0.0, 10.0,
                  "A beam at an edge, whose range differs by more than this from both of its "
                  "neighbors, is not mapped; 0: off.")),
      text("range_correction", &projector.range_correction,
           "Correction that is added to the ranges of a 2D laser: 'range:correction, "
           "range:correction' in m, in quotes, linear between."),
  };
}

std::vector<Parameter> sliceParametersOf(ProjectorConfig& projector) {
  return {
      live(number("laser_z_min_value", "m", &projector.slice_min_m, -100.0, 0.0,
                  "End points below this height, relative to the laser, are not mapped.")),
      live(number("laser_z_max_value", "m", &projector.slice_max_m, 0.0, 100.0,
                  "End points above this height, relative to the laser, are not mapped.")),
      live(number("max_tilt", "rad", &projector.max_tilt_rad, 0.0, 1.5,
                  "Scans of a vehicle that is tilted by more than this are dropped.")),
      number("azimuth_bins", "", &projector.azimuth_bins, 8.0, 100000.0,
             "Number of directions in the slice of a 3D lidar; a larger number keeps more points "
             "and needs more time."),
  };
}

std::vector<Parameter> heightParametersOf(ProjectorConfig& projector) {
  return {
      number("height", "m", &projector.height_m, 0.0, 1000.0,
             "Height of the base above the floor, used if no sensor measures it; 0: unknown."),
      live(number("ceiling_height", "m", &projector.ceiling_m, 0.0, 1000.0,
                  "Height of the ceiling above the floor; 0: unknown.")),
      live(
          number("floor_margin", "m", &projector.floor_margin_m, 0.0, 10.0,
                 "End points closer than this to the floor or the ceiling are not mapped; a larger "
                 "value allows larger errors of the height. An error of the attitude of 1 degree "
                 "is added.")),
      text("mirror_angles", &projector.mirror_angles,
           "Beams that a mirror deflects down to measure the height: 'from:to, from:to' in "
           "degrees in the laser's frame, in quotes."),
      number("mirror_distance", "m", &projector.mirror_distance_m, 0.0, 1.0,
             "Distance from the laser to the mirror."),
  };
}

}  // namespace

std::vector<Parameter> projectionParametersOf(SlamConfig& config) {
  return joined({group("Beams", beamParametersOf(config.projector)),
                 group("Horizontal slice", sliceParametersOf(config.projector)),
                 group("Height, floor and ceiling", heightParametersOf(config.projector))});
}

std::vector<Parameter> attitudeParametersOf(SlamConfig& config) {
  AttitudeConfig& attitude = config.attitude;
  return group(
      "Attitude from the IMU",
      {choice("attitude_source", &attitude.source, {"auto", "orientation", "raw"},
              "orientation: the IMU's own orientation; raw: from its gyro and accelerometer; auto: "
              "the orientation if the IMU gives one, else raw."),
       number("attitude_max_gap", "s", &attitude.buffer.max_gap_s, 0.001, 10.0,
              "Longest time between two IMU messages that is interpolated; scans in a longer gap "
              "are dropped."),
       number("gravity_time", "s", &attitude.gravity_time_s, 0.01, 1000.0,
              "raw: time constant with which gravity corrects the tilt; a larger value is less "
              "disturbed by accelerations, and corrects gyro errors more slowly."),
       number("gravity_gate", "", &attitude.gravity_gate, 0.0, 1.0,
              "raw: largest relative difference between acceleration and gravity at which gravity "
              "corrects the tilt."),
       number("gyro_bias_time", "s", &attitude.bias_time_s, 0.1, 1e6,
              "raw: time constant of the gyro bias estimate; a larger value follows a changing "
              "bias more slowly."),
       number("imu_frozen_time", "s", &attitude.frozen_s, 0.01, 1000.0,
              "Time after which an IMU that repeats the same reading is no longer used."),
       number("imu_silent_time", "s", &attitude.silent_s, 0.01, 1000.0,
              "Time without a message after which the IMU is reported as silent.")});
}

}  // namespace kestrel
