// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/sensor/imu_sample.h"
#include "kestrel_slam/sensor/projection.h"

namespace kestrel {

/// How height readings are checked. All defaults are defined here.
struct HeightConfig {
  double fixed_m = 0.0;  ///< height if nothing measures it; 0: unknown
  double max_m = 50.0;   ///< larger readings are rejected
  /// Faster changes are steps of the surface below, not motion of the vehicle.
  double max_climb_m_s = 3.0;
  double table_time_s = 3.0;  ///< a step that lasts longer than this is the new floor
  double max_age_s = 1.0;     ///< older readings are not used
};

/// Source of a height, in order of preference.
enum class HeightSource { kFilter, kRangeFinder, kMirror, kFloor, kParameter, kNone };

const char* toString(HeightSource source);

/// Height over the floor from the distance to the surface below. A table makes the distance jump,
/// but not the height of the vehicle.
class LevelFollower {
 public:
  explicit LevelFollower(const HeightConfig& config) : config_(config) {}

  /// Adds a reading. `distance_m`: vertical distance to the surface below. Stamps (s) must ascend.
  void add(double stamp, double distance_m);
  /// Adds a height over the floor (m) from another sensor at about the same time. It decides
  /// whether the surface below is a table or the floor.
  void addReference(double stamp, double height_m);
  /// Height over the floor at `time` (s), m; interpolated between readings. Nothing if there is no
  /// reading within max_age_s.
  std::optional<double> height(double time) const;
  /// Height of the surface below over the floor, m; 0: it is the floor.
  double step() const { return step_m_; }
  void restart() { *this = LevelFollower(config_); }

 private:
  struct Reading {
    double stamp;
    double height_m;
  };

  HeightConfig config_;
  std::deque<Reading> readings_;  ///< ascending stamps
  double distance_m_ = 0.0;       ///< distance of the last reading
  double step_m_ = 0.0;
  double step_since_s_ = 0.0;
};

/// Height of the vehicle over the floor, from a pose filter, a range finder that looks down, beams
/// that a mirror deflects downwards, returns from the floor, or a parameter. Every reading is
/// validated and counted. The best source with a recent reading is used.
class HeightTracker {
 public:
  explicit HeightTracker(const HeightConfig& config = HeightConfig());
  ~HeightTracker();
  HeightTracker(HeightTracker&&) noexcept;
  HeightTracker& operator=(HeightTracker&&) noexcept;

  /// Adds a distance along the -z axis of the base, measured from the base's origin. The tilt is
  /// corrected with the attitude at its stamp; without `attitude`, or if it is empty, the base is
  /// assumed to be level. Returns false if the reading is not used.
  bool addRange(const HeightSample& sample, const AttitudeBuffer* attitude);

  /// Adds the height over the surface below that a pose filter estimates (FilterOutput::height). To
  /// be called only while the filter knows it. Returns false if it is not used.
  bool addFiltered(const HeightSample& sample);

  /// Adds the heights over the floor that a projected scan contains. `stamp`: of the sweep, s.
  void addProjection(double stamp, const Projection& projection);

  /// Height of the base over the floor at `time` (s), m.
  std::optional<double> height(double time) const;
  HeightSource source(double time) const;
  /// Height of the surface below the range finder over the floor, m; 0: it is the floor.
  double stepBelow() const;

  /// Number of readings by result: "used", "infinite", "not finite", ...
  const std::map<std::string, std::size_t>& counts() const;

  /// Forgets everything except the counters. To be called if the clock was set back.
  void restart();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
