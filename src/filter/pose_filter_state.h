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

/// What the filter consists of, and how the parts work together.
struct PoseFilter::State {
  explicit State(const PoseFilterConfig& c);

  bool addImu(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu);
  bool begin(const ImuStep& step);
  void place(FilterState& state);
  void advance(const ImuStep& step);
  void addOwnMeasurements(const ImuStep& step);
  bool add(const Measurement& measurement, const std::string& fault);
  void judge(const Measurement& measurement, const Verdict& verdict);
  bool supervise();
  void reset(const std::string& reason, bool distrustful);
  void stop();
  void publish();
  FilterOutput outputOf(const FilterState& state, const ImuInput& reading) const;
  std::string problem(FilterHealth health) const;
  FilterHealth health(double now) const;
  SensorCounts& countsOf(FilterSensor s) { return status.sensors[static_cast<std::size_t>(s)]; }

  PoseFilterConfig config;
  ImuIntake imu;
  Initializer initializer;
  Timeline timeline;
  OdomFrame odom;
  Standstill standstill;
  ImuInput reading;  ///< the newest, in base
  double gravity_stamp = 0.0;
  std::deque<double> reinitializations;  ///< stamps of the last poses that were taken over
  std::optional<FilterOutput> output;
  FilterStatus status;

  std::optional<Measurement> start;  ///< the pose that setPose gave before the start
  std::optional<Measurement> start_range;
  std::optional<FilterOutput> last_known;  ///< before the last reset
};

}  // namespace kestrel
