// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "imu_intake.h"
#include "initializer.h"
#include "kestrel_slam/filter/pose_filter.h"
#include "kestrel_slam/sensor/standstill.h"
#include "odom_frame.h"
#include "timeline.h"

namespace kestrel {

/// The parts of the filter and their interaction.
struct PoseFilter::State {
  explicit State(const PoseFilterConfig& c);

  bool addImu(const CheckedImu& checked);
  bool begin(const ImuStep& step);
  void setInitialPose(FilterState& state);
  void advance(const ImuStep& step);
  void addOwnMeasurements(const ImuStep& step);
  bool add(const Measurement& measurement, const std::string& fault);
  void judge(const Measurement& measurement, const Verdict& verdict);
  bool checkHealth();
  void reset(const std::string& reason, bool biases_uncertain);
  void stop();
  void publish();
  FilterOutput outputOf(const FilterState& state, const InertialInput& reading) const;
  std::string problem(FilterHealth health) const;
  FilterHealth health(double now) const;
  SensorCounts& countsOf(FilterSensor s) { return status.sensors[static_cast<std::size_t>(s)]; }

  PoseFilterConfig config;
  ImuCheck imu_check;  ///< of readings that nobody else has validated
  ImuIntake imu;
  Initializer initializer;
  Timeline timeline;
  OdomFrame odom;
  Standstill standstill;
  InertialInput reading;  ///< the newest one, in the base frame
  double gravity_stamp = 0.0;
  std::deque<double> reinitializations;  ///< stamps of the latest reinitializations
  std::optional<FilterOutput> output;
  FilterStatus status;
  bool gyro_converted = false;  ///< the gyro of the last reading was in degrees per second
  std::string contradiction;    ///< of the values of the last reading

  std::optional<Measurement> initial_pose;   ///< from setPose before the initialization
  std::optional<Measurement> initial_range;  ///< range finder before the initialization
  std::optional<FilterOutput> last_known;    ///< output before the last reset
};

}  // namespace kestrel
