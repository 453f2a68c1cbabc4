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

/// How heights are judged. The defaults live here and nowhere else.
struct HeightConfig {
  double fixed_m = 0.0;        ///< height where nothing measures it; 0: unknown
  double max_m = 50.0;         ///< larger readings are wrong
  double max_climb_m_s = 3.0;  ///< faster changes are steps of what is below, not of the vehicle
  double table_time_s = 3.0;   ///< what is below for longer than this is the floor
  double max_age_s = 1.0;      ///< older readings say nothing
};

/// Who measured a height; the better one first.
enum class HeightSource { kFilter, kRangeFinder, kMirror, kFloor, kParameter, kNone };

const char* toString(HeightSource source);

/// Height over the floor from the distance to whatever is below: a table makes the distance jump,
/// but not the vehicle.
class LevelFollower {
 public:
  explicit LevelFollower(const HeightConfig& config) : config_(config) {}

  /// `distance_m`: straight down, to what is below. Stamps ascend.
  void add(double stamp, double distance_m);
  /// What another sensor says of the height over the floor at about the same time, m.
  void hear(double stamp, double height_m);
  /// Between readings they are interpolated.
  std::optional<double> height(double time) const;
  /// How high the thing below is, m; 0: the floor.
  double step() const { return step_m_; }
  void restart() { *this = LevelFollower(config_); }

 private:
  struct Reading {
    double stamp;
    double height_m;
  };

  HeightConfig config_;
  std::deque<Reading> readings_;  ///< ascending stamps
  double distance_m_ = 0.0;       ///< of the last reading
  double step_m_ = 0.0;
  double step_since_s_ = 0.0;
};

/// What is known of the vehicle's height over the floor: from a pose filter, from a range finder
/// that looks down, from beams that a mirror bends down, from returns of the floor, or from a
/// parameter. Every reading is validated and counted; the best source that has spoken lately is
/// used.
class HeightTracker {
 public:
  explicit HeightTracker(const HeightConfig& config = HeightConfig());
  ~HeightTracker();
  HeightTracker(HeightTracker&&) noexcept;
  HeightTracker& operator=(HeightTracker&&) noexcept;

  /// A reading along the base's negative z axis, from the base's origin. It is put upright with the
  /// attitude at its stamp; `attitude` null or empty: level. False where it is not used.
  bool addRange(const HeightSample& sample, const AttitudeBuffer* attitude);

  /// What a pose filter says of the height over what is below (FilterOutput::height), while it
  /// knows it. False where it is not used.
  bool addFiltered(const HeightSample& sample);

  /// What the projector has seen of the floor in a sweep at `stamp`.
  void addProjection(double stamp, const Projection& projection);

  /// Of the base over the floor, m.
  std::optional<double> height(double time) const;
  HeightSource source(double time) const;
  /// How high the thing below the range finder is, m; 0: the floor.
  double stepBelow() const;

  /// Readings by what became of them: "used", "infinite", "not finite", ...
  const std::map<std::string, std::size_t>& counts() const;

  /// Forgets everything but the counts: for a clock that was set back.
  void restart();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
