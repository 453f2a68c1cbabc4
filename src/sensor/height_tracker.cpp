// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/height_tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/sensor/imu_validation.h"
#include "kestrel_slam/sensor/stamp_check.h"

namespace kestrel {
namespace {

constexpr double kNoise_m = 0.1;  // noise of a reading: allowed difference without any motion
// Allowed difference between two sensors that measure the same height.
constexpr double kAgreement_m = 0.15;
const double kMaxTilt = degToRad(45.0);  // at larger tilts the range finder may hit a wall

/// The same configuration for a sensor that measures the floor itself, so that no step detection is
/// needed.
HeightConfig withoutSteps(HeightConfig config) {
  config.max_climb_m_s = std::numeric_limits<double>::infinity();
  return config;
}

/// Cosine of the tilt at `stamp`, or at the newest attitude if there is none at `stamp`.
double tiltCosine(double stamp, const AttitudeBuffer* attitude) {
  Attitude at;
  if (attitude == nullptr || !attitude->latest()) return 1.0;
  if (attitude->lookup(stamp, at) != AttitudeError::kNone)
    attitude->lookup(*attitude->latest(), at);
  return std::cos(tiltOf(at.stabilized_R_base));
}

}  // namespace

const char* toString(HeightSource source) {
  switch (source) {
    case HeightSource::kFilter:
      return "pose filter";
    case HeightSource::kRangeFinder:
      return "range finder";
    case HeightSource::kMirror:
      return "mirror of the laser";
    case HeightSource::kFloor:
      return "returns from the floor";
    case HeightSource::kParameter:
      return "parameter";
    case HeightSource::kNone:
      return "none";
  }
  return "unknown";
}

void LevelFollower::add(double stamp, double distance_m) {
  if (!readings_.empty() && stamp - readings_.back().stamp > config_.max_age_s) restart();
  if (!readings_.empty()) {
    const Reading& last = readings_.back();
    const double allowed = config_.max_climb_m_s * (stamp - last.stamp) + kNoise_m;
    const bool is_on_floor = std::abs(distance_m - last.height_m) <= allowed;
    const bool is_on_step = std::abs(distance_m + step_m_ - last.height_m) <= allowed;
    if (!is_on_step) {
      step_m_ = is_on_floor ? 0.0 : last.height_m - distance_m;
      step_since_s_ = stamp;
    }
    if (stamp - step_since_s_ > config_.table_time_s) step_m_ = 0.0;
  }
  distance_m_ = distance_m;
  readings_.push_back({stamp, distance_m + step_m_});
  while (readings_.front().stamp < stamp - config_.max_age_s) readings_.pop_front();
}

void LevelFollower::addReference(double stamp, double height_m) {
  if (readings_.empty() || std::abs(stamp - readings_.back().stamp) > config_.max_age_s) return;
  if (std::abs(height_m - distance_m_) <= kAgreement_m) {
    step_m_ = 0.0;
    readings_.back().height_m = distance_m_;
  } else if (std::abs(height_m - distance_m_ - step_m_) <= kAgreement_m) {
    step_since_s_ = stamp;  // the reference confirms the step, so it does not expire
  }
}

std::optional<double> LevelFollower::height(double time) const {
  if (readings_.empty() || !(time <= readings_.back().stamp + config_.max_age_s) ||
      time < readings_.front().stamp - config_.max_age_s) {
    return std::nullopt;
  }
  const auto after = std::lower_bound(readings_.begin(), readings_.end(), time,
                                      [](const Reading& r, double t) { return r.stamp < t; });
  if (after == readings_.begin()) return after->height_m;
  const Reading& before = *(after - 1);
  if (after == readings_.end()) return before.height_m;
  const double share = (time - before.stamp) / (after->stamp - before.stamp);
  return before.height_m + share * (after->height_m - before.height_m);
}

struct HeightTracker::State {
  explicit State(const HeightConfig& c)
      : config(c), filter(c), range_finder(c), mirror(c), floor(withoutSteps(c)) {}

  /// Return "used", or the reason why the reading is rejected.
  std::string addRange(const HeightSample& sample, const AttitudeBuffer* attitude);
  std::string addFiltered(const HeightSample& sample);
  std::string faultOf(const HeightSample& sample, StampCheck& stamps);
  std::string addSeen(double stamp, double height_m, LevelFollower& source);
  std::string faultOf(double height_m) const;
  HeightSource best(double time, std::optional<double>& height) const;
  void forget();

  HeightConfig config;
  LevelFollower filter, range_finder, mirror, floor;
  StampCheck filter_stamps, range_stamps, sweep_stamps;
  std::map<std::string, std::size_t> counts;
};

HeightTracker::HeightTracker(const HeightConfig& config)
    : state_(std::make_unique<State>(config)) {}
HeightTracker::~HeightTracker() = default;
HeightTracker::HeightTracker(HeightTracker&&) noexcept = default;
HeightTracker& HeightTracker::operator=(HeightTracker&&) noexcept = default;

void HeightTracker::restart() {
  state_->forget();
  state_->filter_stamps.restart();
  state_->range_stamps.restart();
  state_->sweep_stamps.restart();
}

void HeightTracker::State::forget() {
  filter.restart();
  range_finder.restart();
  mirror.restart();
  floor.restart();
}

std::string HeightTracker::State::faultOf(double height_m) const {
  if (std::isnan(height_m)) return "not finite";
  if (std::isinf(height_m)) return height_m > 0.0 ? "infinite" : "too close";
  if (height_m <= 0.0) return "not positive";
  return height_m > config.max_m ? "too far" : "";
}

std::string HeightTracker::State::faultOf(const HeightSample& sample, StampCheck& stamps) {
  if (faultOfStamp(sample.stamp)) return "bad stamp";
  const StampCheck::Verdict verdict = stamps.check(sample.stamp);
  if (verdict == StampCheck::Verdict::kLate) return "late";
  if (verdict == StampCheck::Verdict::kJump) return "stamp jumps";
  if (verdict == StampCheck::Verdict::kSetBack) forget();
  return faultOf(sample.height_m);
}

std::string HeightTracker::State::addRange(const HeightSample& sample,
                                           const AttitudeBuffer* attitude) {
  const std::string fault = faultOf(sample, range_stamps);
  if (!fault.empty()) return fault;
  const double cosine = tiltCosine(sample.stamp, attitude);
  if (cosine < std::cos(kMaxTilt)) return "tilted";
  range_finder.add(sample.stamp, sample.height_m * cosine);
  return "used";
}

bool HeightTracker::addRange(const HeightSample& sample, const AttitudeBuffer* attitude) {
  const std::string result = state_->addRange(sample, attitude);
  ++state_->counts[result];
  return result == "used";
}

std::string HeightTracker::State::addFiltered(const HeightSample& sample) {
  const std::string fault = faultOf(sample, filter_stamps);
  if (!fault.empty()) return fault;
  filter.add(sample.stamp, sample.height_m);
  return "used";
}

bool HeightTracker::addFiltered(const HeightSample& sample) {
  const std::string result = state_->addFiltered(sample);
  ++state_->counts["filter: " + result];
  return result == "used";
}

std::string HeightTracker::State::addSeen(double stamp, double height_m, LevelFollower& source) {
  const std::string fault = faultOf(height_m);
  if (!fault.empty()) return fault;
  source.add(stamp, height_m);
  for (LevelFollower* other : {&filter, &range_finder})
    other->addReference(stamp, *source.height(stamp));
  return "used";
}

void HeightTracker::addProjection(double stamp, const Projection& projection) {
  const bool sees_floor = projection.mirror_height_m || projection.floor_height_m;
  if (!sees_floor || faultOfStamp(stamp)) return;
  const StampCheck::Verdict verdict = state_->sweep_stamps.check(stamp);
  if (verdict == StampCheck::Verdict::kLate || verdict == StampCheck::Verdict::kJump) return;
  if (verdict == StampCheck::Verdict::kSetBack) state_->forget();
  if (projection.mirror_height_m) {
    ++state_->counts["mirror: " +
                     state_->addSeen(stamp, *projection.mirror_height_m, state_->mirror)];
  }
  if (projection.floor_height_m) {
    ++state_->counts["floor: " + state_->addSeen(stamp, *projection.floor_height_m, state_->floor)];
  }
}

HeightSource HeightTracker::State::best(double time, std::optional<double>& height) const {
  if ((height = filter.height(time))) return HeightSource::kFilter;
  if ((height = range_finder.height(time))) return HeightSource::kRangeFinder;
  if ((height = mirror.height(time))) return HeightSource::kMirror;
  if ((height = floor.height(time))) return HeightSource::kFloor;
  if (!(config.fixed_m > 0.0)) return HeightSource::kNone;
  height = config.fixed_m;
  return HeightSource::kParameter;
}

std::optional<double> HeightTracker::height(double time) const {
  std::optional<double> height;
  state_->best(time, height);
  return height;
}

HeightSource HeightTracker::source(double time) const {
  std::optional<double> height;
  return state_->best(time, height);
}

double HeightTracker::stepBelow() const { return state_->range_finder.step(); }

const std::map<std::string, std::size_t>& HeightTracker::counts() const { return state_->counts; }

}  // namespace kestrel
