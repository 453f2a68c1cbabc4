// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/projection_stage.h"

#include <cmath>
#include <cstdio>
#include <utility>

#include "kestrel_slam/sensor/scan_turn.h"

namespace kestrel {
namespace {

constexpr double kMaxVelocityAge = 0.3;  // s; older velocities are not used
constexpr double kMaxVelocity = 100.0;   // m/s; larger ones are garbage
constexpr double kMaxYawRate = 12.0;     // rad/s; likewise
constexpr double kOtherClock = 1.0;      // s; larger differences: the stamps come from two clocks

HeightConfig heightConfigOf(const ProjectorConfig& projector) {
  HeightConfig config;
  config.fixed_m = projector.height_m;
  return config;
}

bool isGone(ImuHealth health) {
  return health == ImuHealth::kNoData || health == ImuHealth::kSilent;
}

/// True if the IMU data cannot be used.
bool hasFailed(ImuHealth health) {
  return isGone(health) || health == ImuHealth::kFrozen || health == ImuHealth::kInvalid;
}

std::string reasonOf(ImuHealth health, AttitudeError error) {
  switch (health) {
    case ImuHealth::kNoData:
      return "no-imu";
    case ImuHealth::kSilent:
      return "imu-silent";
    case ImuHealth::kFrozen:
      return "imu-frozen";
    case ImuHealth::kInvalid:
      return "imu-invalid";
    default:
      return toString(error);
  }
}

/// The nodes exchange heights as sensor_msgs/Range in single precision. Rounding here gives the
/// same value without a message.
void roundHeights(Projection& projection) {
  for (std::optional<double>* height : {&projection.mirror_height_m, &projection.floor_height_m}) {
    if (*height) *height = static_cast<double>(static_cast<float>(**height));
  }
}

}  // namespace

double stampOf(const SweepData& data) {
  return std::visit([](const auto& sweep) { return sweep.stamp; }, data);
}

const std::string& frameOf(const SweepData& data) {
  return std::visit([](const auto& sweep) -> const std::string& { return sweep.frame; }, data);
}

SweepTimes sweepTimes(const SweepData& data) {
  return std::visit([](const auto& sweep) { return sweepTimes(sweep); }, data);
}

ProjectionStage::ProjectionStage(const ProjectionStageConfig& config)
    : config_(config),
      projector_(config.projector),
      tracker_(config.attitude),
      motions_(config.attitude.buffer),
      heights_(heightConfigOf(config.projector)) {}

bool ProjectionStage::addImu(const CheckedImu& reading) { return tracker_.add(reading); }

bool ProjectionStage::addMotion(const FilteredMotion& motion) {
  if (motion.height_m) heights_.addFiltered({motion.stamp, *motion.height_m});
  if (!motions_.add(motion)) return false;
  if (motion.gives_prediction) {
    addVelocity(motion.stamp, motion.velocity, motion.angular_velocity.z());
  }
  return true;
}

bool ProjectionStage::addRange(const HeightSample& sample, bool is_upright) {
  return heights_.addRange(sample, is_upright ? nullptr : &tracker_.buffer());
}

void ProjectionStage::addVelocity(double stamp, const Eigen::Vector2d& velocity, double yaw_rate) {
  const bool is_older = stamp < velocity_stamp_ && velocity_stamp_ - stamp < kMaxVelocityAge;
  // The comparisons are false for NaN.
  if (is_older || !(velocity.norm() < kMaxVelocity)) return;
  velocity_stamp_ = stamp;
  velocity_ = velocity;
  yaw_rate_ = std::abs(yaw_rate) < kMaxYawRate ? yaw_rate : 0.0;
}

VehicleState ProjectionStage::vehicleAt(double time, const AttitudeBuffer* attitude) const {
  VehicleState result{attitude, heights_.height(time)};
  if (std::abs(time - velocity_stamp_) < kMaxVelocityAge) {
    result.velocity = velocity_;
    result.yaw_rate = yaw_rate_;
  }
  return result;
}

SweepDecision ProjectionStage::judge(const SweepTimes& times, double waited_s, double now) const {
  if (config_.level) return {SweepDecision::kProjectLevel, "", ""};
  const AttitudeError error = tracker_.buffer().covers(times.first, times.last);
  if (error == AttitudeError::kNone) {
    return {waitsForFilter(times, waited_s) ? SweepDecision::kWait : SweepDecision::kProject, "",
            ""};
  }
  const ImuStatus imu = tracker_.status(now);
  const bool may_come = error == AttitudeError::kEmpty || error == AttitudeError::kNotYet;
  const bool is_hopeless = config_.level_without_imu && isGone(imu.health);
  if (may_come && waited_s < config_.max_wait_s && !is_hopeless) {
    return {SweepDecision::kWait, "", ""};
  }
  if (config_.level_without_imu && hasFailed(imu.health)) {
    return {SweepDecision::kProjectLevel, "", ""};
  }
  return {SweepDecision::kDrop, reasonOf(imu.health, error),
          hasFailed(imu.health) ? imu.message : uncovered(times)};
}

/// A running filter publishes its state shortly after each IMU reading.
bool ProjectionStage::waitsForFilter(const SweepTimes& times, double waited_s) const {
  return motions_.runs(times.last) &&
         motions_.attitude().covers(times.first, times.last) == AttitudeError::kNotYet &&
         waited_s < config_.max_wait_s;
}

/// Compares the time of a sweep with the times of the attitudes.
std::string ProjectionStage::uncovered(const SweepTimes& times) const {
  const std::optional<double> latest = tracker_.buffer().latest();
  if (!latest) return "no attitude has been received yet";
  const double ahead = times.last - *latest;
  char text[200];
  std::snprintf(text, sizeof text, "its last beam is %.3f s %s than the newest attitude%s",
                std::abs(ahead), ahead > 0.0 ? "newer" : "older",
                std::abs(ahead) > kOtherClock
                    ? "; do the stamps of laser and IMU come from the same clock?"
                    : "");
  return text;
}

ProjectedSweep ProjectionStage::project(const SweepData& data,
                                        const Eigen::Isometry3d& base_T_laser, bool level,
                                        const std::optional<Pose2>& odom_T_base) {
  checkMounting(data, base_T_laser, odom_T_base);
  const double stamp = stampOf(data);
  const SweepTimes times = sweepTimes(data);
  ProjectedSweep result;
  result.level = level;
  result.filtered =
      !level && motions_.attitude().covers(times.first, times.last) == AttitudeError::kNone;
  const AttitudeBuffer* attitude = level             ? nullptr
                                   : result.filtered ? &motions_.attitude()
                                                     : &tracker_.buffer();
  const VehicleState vehicle = vehicleAt(stamp, attitude);
  Projection& projection = result.projection;
  projection = std::visit(
      [&](const auto& sweep) { return projector_.project(sweep, base_T_laser, vehicle); }, data);
  roundHeights(projection);
  heights_.addProjection(stamp, projection);
  if (projection.error != ScanError::kNone) return result;
  if (attitude != nullptr) continueIntegrals(*attitude, projection.scan);
  if (!level) projection.scan.predicted = motions_.odomPose(stamp);
  if (mountings_.gyroMisleads()) {
    projection.scan.integrated_yaw.reset();
    projection.scan.integrated_acceleration.reset();
    projection.scan.predicted.reset();
  }
  return result;
}

/// The integrals of the IMU and of the pose filter start at different values. If the source
/// changes, the new one continues with the values of the old one.
void ProjectionStage::continueIntegrals(const AttitudeBuffer& attitude, PlanarScan& scan) {
  if (!scan.integrated_yaw) return;
  const std::optional<IntegralOffset> offset =
      last_attitude_ == &attitude ? integral_offset_ : offsetTo(attitude, scan);
  last_attitude_ = &attitude;
  integral_offset_ = offset.value_or(IntegralOffset());
  *scan.integrated_yaw += integral_offset_.yaw;
  if (scan.integrated_acceleration) {
    scan.integrated_acceleration =
        Eigen::Rotation2Dd(integral_offset_.yaw) * *scan.integrated_acceleration +
        integral_offset_.velocity;
  }
  last_integrals_ = {scan.stamp, *scan.integrated_yaw, scan.integrated_acceleration};
  if (offset) return;
  // They cannot be compared with those of the last scan.
  scan.integrated_yaw.reset();
  scan.integrated_acceleration.reset();
}

/// From the integrals of `attitude` to those given to the mapper: at the time of the last scan, if
/// `attitude` reaches back to it, or at the time of `scan`, if the old source still runs.
std::optional<ProjectionStage::IntegralOffset> ProjectionStage::offsetTo(
    const AttitudeBuffer& attitude, const PlanarScan& scan) const {
  if (!last_attitude_) return IntegralOffset();
  Attitude there;
  if (last_integrals_ && attitude.lookup(last_integrals_->stamp, there) == AttitudeError::kNone) {
    return offsetBetween(there.integrated_yaw, there.integrated_acceleration, last_integrals_->yaw,
                         last_integrals_->velocity);
  }
  if (last_attitude_->lookup(scan.stamp, there) != AttitudeError::kNone) return std::nullopt;
  if (there.integrated_acceleration) {
    there.integrated_acceleration =
        Eigen::Rotation2Dd(integral_offset_.yaw) * *there.integrated_acceleration +
        integral_offset_.velocity;
  }
  return offsetBetween(*scan.integrated_yaw, scan.integrated_acceleration,
                       there.integrated_yaw + integral_offset_.yaw, there.integrated_acceleration);
}

ProjectionStage::IntegralOffset ProjectionStage::offsetBetween(
    double yaw, const std::optional<Eigen::Vector2d>& velocity, double given_yaw,
    const std::optional<Eigen::Vector2d>& given_velocity) {
  IntegralOffset result;
  result.yaw = given_yaw - yaw;
  if (velocity && given_velocity) {
    result.velocity = *given_velocity - Eigen::Rotation2Dd(result.yaw) * *velocity;
  }
  return result;
}

void ProjectionStage::checkMounting(const SweepData& data, const Eigen::Isometry3d& base_T_laser,
                                    const std::optional<Pose2>& odom_T_base) {
  const double stamp = stampOf(data);
  const SweepTimes times = sweepTimes(data);
  const double middle = 0.5 * (times.first + times.last);
  const std::string& source = frameOf(data);
  if (!std::isfinite(middle) || !base_T_laser.matrix().allFinite()) return;
  mountings_.addMounting(source, base_T_laser);
  const bool is_compared = !config_.level || odom_T_base;
  if (is_compared && mountings_.isDue(source, middle)) {
    std::vector<float> ranges =
        std::visit([](const auto& sweep) { return rangesAround(sweep); }, data);
    mountings_.addScan(source, middle, std::move(ranges), base_T_laser);
    if (!config_.level) mountings_.compareGyro(tracker_.buffer());
  }
  if (odom_T_base) mountings_.addOdometry(stamp, odom_T_base->yaw);
}

std::vector<ImuFault> ProjectionStage::problems(double now) const {
  std::vector<ImuFault> problems = mountings_.problems();
  if (config_.level) {
    for (ImuFault& problem : mountings_.problemsOfLevelLaser()) problems.push_back(problem);
    return problems;
  }
  const ImuStatus imu = tracker_.status(now);
  if (!isGone(imu.health) && !imu.message.empty()) {
    problems.insert(problems.begin(), ImuFault{imu.reason, imu.message});
  }
  return problems;
}

}  // namespace kestrel
