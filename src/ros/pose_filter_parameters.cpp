#include "kestrel_slam/ros/pose_filter_parameters.h"

#include <iterator>
#include <map>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/mapping/parameter_table.h"
#include "kestrel_slam/ros/private_parameters.h"
#include "kestrel_slam/tools/bag_transforms.h"

namespace kestrel_slam {
namespace {

using namespace parameter_table;

constexpr double kTiny = 1e-9, kHuge = 1e6;

/// Parameters of hector_pose_estimation, and what does their job here.
const std::map<std::string, std::string>& unneededParameters() {
  static const std::map<std::string, std::string> table = {
      {"nav_frame", "the pose is published in ~odom_frame, the correction to ~map_frame by tf"},
      {"publish_covariances", "they always are"},
  };
  return table;
}

std::vector<Parameter> nodeParametersOf(PoseFilterNodeConfig& config) {
  return {
      text("base_frame", &config.base_frame, "the vehicle's frame"),
      text("base_stabilized_frame", &config.base_stabilized_frame,
           "heights in this frame are upright, not along a slanted beam"),
      text("base_footprint_frame", &config.base_footprint_frame,
           "the vehicle's frame down on the floor: child of odom_frame in tf"),
      text("map_frame", &config.map_frame, "the frame of the poses on pose_topic"),
      text("odom_frame", &config.odom_frame, "the smooth frame of odom/filtered"),
      text("imu_topic", &config.imu_topic, "topic of the IMU"),
      text("pose_topic", &config.pose_topic, "topic of the mapper's poses; empty: none"),
      text("height_topic", &config.height_topic,
           "topic of a range finder that looks down; empty: none"),
      text("pressure_topic", &config.pressure_topic, "topic of a barometer; empty: none"),
      text("pressure_height_topic", &config.pressure_height_topic,
           "topic of a barometer whose driver gives a height; empty: none"),
      text("magnetometer_topic", &config.magnetometer_topic,
           "topic of a magnetometer, where the map's x axis points east; empty: none"),
      text("fix_topic", &config.fix_topic,
           "topic of GPS fixes, where the map's x axis points east; empty: none"),
      number("magnetic_declination", "rad", &config.magnetic_declination, -kPi, kPi,
             "of the place, positive to the east"),
      flag("pub_map_odom_transform", &config.pub_map_odom_transform,
           "publish map_frame -> odom_frame"),
      flag("pub_odom_base_transform", &config.pub_odom_base_transform,
           "publish odom_frame -> base_footprint_frame"),
  };
}

std::vector<Parameter> imuParametersOf(PoseFilterConfig& filter) {
  ImuNoiseConfig& noise = filter.noise;
  ImuInputConfig& imu = filter.imu;
  return {
      number("gyro_noise", "rad/s/sqrt(Hz)", &noise.gyro_noise, kTiny, kHuge, "its density"),
      number("accelerometer_noise", "m/s²/sqrt(Hz)", &noise.accelerometer_noise, kTiny, kHuge,
             "its density"),
      number("gyro_bias_walk", "rad/s²/sqrt(Hz)", &noise.gyro_bias_walk, 0.0, kHuge,
             "how fast the gyro's bias wanders"),
      number("accelerometer_bias_walk", "m/s³/sqrt(Hz)", &noise.accelerometer_bias_walk, 0.0, kHuge,
             "how fast the accelerometer's bias wanders"),
      number("gyro_bias_sigma", "rad/s", &noise.gyro_bias_sigma, kTiny, kHuge,
             "of the gyro's bias before anything is known"),
      number("accelerometer_bias_sigma", "m/s²", &noise.accelerometer_bias_sigma, kTiny, kHuge,
             "of the accelerometer's bias before anything is known"),
      number("mounting_sigma", "rad", &noise.mounting_sigma_rad, 0.0, 1.0,
             "of roll and pitch of the IMU on the vehicle"),
      number("gyro_range", "rad/s", &noise.gyro_range, kTiny, kHuge,
             "readings of this size are saturated"),
      number("accelerometer_range", "m/s²", &noise.accelerometer_range, kTiny, kHuge,
             "readings of this size are saturated"),
      number("max_imu_rate", "Hz", &imu.max_rate_hz, 50.0, 2000.0, "denser readings are averaged"),
      number("min_imu_rate", "Hz", &imu.min_rate_hz, kTiny, 2000.0,
             "below, diagnostics warn of the coarse integration"),
      number("imu_frozen_time", "s", &imu.frozen_s, kTiny, kHuge,
             "identical readings for this long are not used"),
      number("imu_silent_time", "s", &imu.silent_s, kTiny, kHuge,
             "after this long without a reading the IMU is silent"),
      number("imu_max_gap", "s", &imu.max_gap_s, kTiny, kHuge,
             "after a longer gap the attitude begins anew"),
      number("max_gyro_bias", "rad/s", &filter.max_gyro_bias, kTiny, kHuge,
             "a larger estimate means a broken gyro: the filter starts anew"),
      number("max_accelerometer_bias", "m/s²", &filter.max_accelerometer_bias, kTiny, kHuge,
             "a larger estimate means a broken accelerometer: the filter starts anew"),
  };
}

std::vector<Parameter> fusionParametersOf(PoseFilterConfig& filter) {
  GateConfig& gate = filter.gate;
  HeightFusionConfig& height = filter.height;
  MotionConfig& motion = filter.motion;
  return {
      number("gate_probability", "", &gate.probability, 0.5, 1.0 - kTiny,
             "share of the right measurements that pass their gate"),
      number("history", "s", &gate.history_s, 0.05, 10.0, "later measurements come too late"),
      number(
          "anchor_after", "s", &gate.anchor_after_s, kTiny, kHuge,
          "poses that are refused for this long in a row are right: the map has corrected itself"),
      number("coast_after", "s", &gate.coast_after_s, kTiny, kHuge,
             "after this long without a pose or position the state is coasting"),
      number("range_sigma", "m", &height.range_sigma_m, kTiny, kHuge, "of the range finder"),
      number("range_max", "m", &height.range_max_m, kTiny, kHuge, "longer readings are wrong"),
      number("floor_beam_sigma", "m", &height.floor_beam_sigma_m, kTiny, kHuge,
             "of a height that the projector measures"),
      number("barometer_sigma", "m", &height.barometer_sigma_m, kTiny, kHuge, "of one reading"),
      number("barometer_drift", "m/sqrt(s)", &height.barometer_drift, 0.0, kHuge,
             "how fast its offset wanders"),
      number("gravity_sigma", "m/s²", &motion.gravity_sigma, 0.0, kHuge,
             "of the vehicle's own acceleration, where gravity is measured; 0: it is not"),
      number("gravity_gate", "", &motion.gravity_gate, 0.0, 1.0,
             "share by which the acceleration may differ from gravity to be used"),
      number("gravity_period", "s", &motion.gravity_period_s, kTiny, kHuge,
             "time between two measurements of gravity"),
      flag("zero_velocity", &motion.zero_velocity, "a standstill says that the velocity is zero"),
      number("zero_velocity_sigma", "m/s", &motion.zero_velocity_sigma, kTiny, kHuge, "of that"),
      number("start_speed_sigma", "m/s", &motion.start_speed_sigma, kTiny, kHuge,
             "of the velocity of a start in the air"),
      number("heading_sigma", "rad", &filter.heading_sigma_rad, kTiny, kHuge,
             "of a magnetometer's heading"),
  };
}

}  // namespace

std::vector<Parameter> parametersOf(PoseFilterNodeConfig& config) {
  std::vector<Parameter> all = nodeParametersOf(config);
  for (std::vector<Parameter> more :
       {imuParametersOf(config.filter), fusionParametersOf(config.filter)}) {
    all.insert(all.end(), std::make_move_iterator(more.begin()),
               std::make_move_iterator(more.end()));
  }
  return all;
}

PoseFilterNodeConfig loadPoseFilterParameters(const ros::NodeHandle& private_nh) {
  PoseFilterNodeConfig config;
  readPrivateParameters(private_nh, parametersOf(config), unneededParameters());
  for (std::string* frame : {&config.base_frame, &config.base_stabilized_frame,
                             &config.base_footprint_frame, &config.map_frame, &config.odom_frame}) {
    *frame = withoutSlash(*frame);
  }
  requireName("base_frame", config.base_frame);
  requireName("base_footprint_frame", config.base_footprint_frame);
  requireName("map_frame", config.map_frame);
  requireName("odom_frame", config.odom_frame);
  requireName("imu_topic", config.imu_topic);
  requireDistinct("odom_frame", config.odom_frame, config.map_frame);
  requireDistinct("base_footprint_frame", config.base_footprint_frame, config.odom_frame);
  validate(config.filter);
  return config;
}

}  // namespace kestrel_slam
