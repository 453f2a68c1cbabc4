// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/scan_projector_node.h"

#include <ros/console.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <utility>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/recording/bag/bag_odometry.h"

namespace kestrel {
namespace {

constexpr double kPatrolPeriod = 0.01;  // s; how often sweeps that wait are looked at
constexpr double kComplainEvery = 5.0;  // s
constexpr double kOtherClock = 1.0;     // s; stamps that differ by more are of two clocks

bool isGone(ImuHealth health) {
  return health == ImuHealth::kNoData || health == ImuHealth::kSilent;
}

/// Whether the IMU gives nothing that could be used.
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

}  // namespace

ScanProjectorNode::ScanProjectorNode(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : config_(loadProjectorParameters(private_nh)),
      projector_(config_.slam.projector),
      queue_(static_cast<std::size_t>(config_.queue_size)),
      tracker_(config_.slam.attitude),
      mountings_(nh, config_.base_frame),
      tf_attitude_(mountings_.buffer(), config_.attitude_frame, config_.base_frame, tracker_),
      filter_(nh, config_,
              [this](const ros::Time& stamp) {
                publishAttitude(stamp, &filter_.buffer());
                processQueue();
              }),
      height_(nh, config_, mountings_, tracker_.buffer()),
      velocity_(nh, config_, tracker_.buffer()),
      scan_publisher_(nh, config_),
      attitude_publisher_(config_) {
  if (config_.usesImu()) {
    imu_ = std::make_unique<ImuInput>(nh, config_.imu_topic, mountings_, tracker_,
                                      [this](const ros::Time& stamp) { onAttitude(stamp); });
  }
  input_ = std::make_unique<SweepInput>(nh, config_, statistics_,
                                        [this](Sweep sweep) { enqueue(std::move(sweep)); });
  diagnostics_ = std::make_unique<ProjectorDiagnostics>(
      nh, private_nh, input_->topics(), [this] { return report(); },
      [this] { statistics_.dropped_lately = 0; });
  timer_ = nh.createSteadyTimer(ros::WallDuration(kPatrolPeriod),
                                [this](const ros::SteadyTimerEvent&) { processQueue(); });
  ProjectorReport start;
  describeAttitude(start);
  ROS_INFO("Projecting %s; attitude from %s.", input_->topics().c_str(),
           start.attitude_hint.c_str());
}

void ScanProjectorNode::enqueue(Sweep sweep) {
  if (!queue_.push(std::move(sweep))) {
    statistics_.drop("overload", "more than ~queue_size scans wait for their attitude");
  }
  processQueue();
}

void ScanProjectorNode::processQueue() {
  queue_.process([this](const Sweep& sweep) {
    try {
      return handle(sweep);
    } catch (const std::exception& error) {
      drop(sweep, "internal-error", error.what());
      return true;
    }
  });
}

/// True where the sweep does not have to wait any more.
bool ScanProjectorNode::handle(const Sweep& sweep) {
  const std::optional<Eigen::Isometry3d> base_T_laser = mountings_.lookup(sweep.frame);
  if (!base_T_laser) {
    waiting_for_ = mountings_.missing("laser", sweep.frame);
    if (sweep.waiting.seconds() < config_.max_wait_s) return false;
    drop(sweep, "no-transform", waiting_for_);
    return true;
  }
  waiting_for_.clear();
  const Verdict verdict = judge(sweep);
  if (verdict.kind == Verdict::kWait) return false;
  if (verdict.kind == Verdict::kDrop) {
    drop(sweep, verdict.reason, verdict.sentence);
  } else {
    project(sweep, *base_T_laser, verdict.kind == Verdict::kProjectLevel);
  }
  return true;
}

ScanProjectorNode::Verdict ScanProjectorNode::judge(const Sweep& sweep) {
  if (config_.isLevel()) return {Verdict::kProjectLevel, "", ""};
  return config_.usesTf() ? judgeTfAttitude(sweep) : judgeImuAttitude(sweep);
}

ScanProjectorNode::Verdict ScanProjectorNode::judgeTfAttitude(const Sweep& sweep) {
  if (tf_attitude_.fetch(sweep.times)) {
    tf_error_.clear();
    return {Verdict::kProject, "", ""};
  }
  if (sweep.waiting.seconds() < config_.max_wait_s) return {Verdict::kWait, "", ""};
  tf_error_ = tf_attitude_.missing();
  if (config_.without_imu == "level") return {Verdict::kProjectLevel, "", ""};
  return {Verdict::kDrop, "no-attitude-in-tf", tf_error_};
}

ScanProjectorNode::Verdict ScanProjectorNode::judgeImuAttitude(const Sweep& sweep) const {
  const AttitudeError error = tracker_.buffer().covers(sweep.times.first, sweep.times.last);
  if (error == AttitudeError::kNone) {
    return {waitsForFilter(sweep) ? Verdict::kWait : Verdict::kProject, "", ""};
  }
  const bool may_come = error == AttitudeError::kEmpty || error == AttitudeError::kNotYet;
  const bool takes_level = config_.without_imu == "level";
  if (may_come && sweep.waiting.seconds() < config_.max_wait_s) {
    const bool is_hopeless = takes_level && isGone(imu_->status().health);
    if (!is_hopeless) return {Verdict::kWait, "", ""};
  }
  const ImuStatus status = imu_->status();
  if (takes_level && hasFailed(status.health)) return {Verdict::kProjectLevel, "", ""};
  if (!imu_->waitingFor().empty()) return {Verdict::kDrop, "imu-no-transform", imu_->waitingFor()};
  return {Verdict::kDrop, reasonOf(status.health, error),
          hasFailed(status.health) ? status.message : uncovered(sweep)};
}

/// A filter that runs needs its moment after the IMU; where it does not come, the IMU has to do.
bool ScanProjectorNode::waitsForFilter(const Sweep& sweep) const {
  return filter_.runs(sweep.times.last) && filter_.covers(sweep.times) == AttitudeError::kNotYet &&
         sweep.waiting.seconds() < config_.max_wait_s;
}

/// How the time of a sweep lies to the attitudes.
std::string ScanProjectorNode::uncovered(const Sweep& sweep) const {
  const std::optional<double> latest = tracker_.buffer().latest();
  if (!latest) return "no attitude has come yet";
  const double ahead = sweep.times.last - *latest;
  char text[200];
  std::snprintf(text, sizeof text, "its last beam is %.3f s %s than the newest attitude%s",
                std::abs(ahead), ahead > 0.0 ? "newer" : "older",
                std::abs(ahead) > kOtherClock
                    ? "; do the stamps of laser and IMU come from the same clock?"
                    : "");
  return text;
}

void ScanProjectorNode::project(const Sweep& sweep, const Eigen::Isometry3d& base_T_laser,
                                bool is_level) {
  const double stamp = toSeconds(sweep.stamp);
  const bool is_filtered = !is_level && filter_.covers(sweep.times) == AttitudeError::kNone;
  const AttitudeBuffer* attitude = is_level      ? nullptr
                                   : is_filtered ? &filter_.buffer()
                                                 : &tracker_.buffer();
  const VehicleState vehicle{attitude, height_.height(stamp), velocity_.velocity(stamp)};
  Projection projection =
      std::visit([&](const auto& data) { return projector_.project(data, base_T_laser, vehicle); },
                 sweep.data);
  if (last_attitude_ != nullptr &&
      attitude != last_attitude_) {  // yaw and speed count from elsewhere now
    projection.scan.integrated_yaw.reset();
    projection.scan.integrated_acceleration.reset();
  }
  if (attitude != nullptr) last_attitude_ = attitude;
  if (is_filtered) projection.scan.predicted = filter_.predicted(stamp);
  if (projection.error != ScanError::kNone) {
    drop(sweep, toString(projection.error), projection.message);
    return;
  }
  ++statistics_.projected;
  if (is_level) ++statistics_.projected_level;
  if (is_filtered) ++statistics_.projected_filtered;
  statistics_.beams = projection.counts;
  height_.add(projection);
  scan_publisher_.publish(sweep.stamp, projection);
  if (!imu_) publishAttitude(sweep.stamp, is_level ? nullptr : &tracker_.buffer());
}

void ScanProjectorNode::drop(const Sweep& sweep, const std::string& reason,
                             const std::string& sentence) {
  statistics_.drop(reason, sentence);
  ROS_WARN_THROTTLE(kComplainEvery, "A scan on %s is dropped (%s): %s", sweep.topic.c_str(),
                    reason.c_str(), sentence.c_str());
}

void ScanProjectorNode::onAttitude(const ros::Time& stamp) {
  if (!filter_.runs(toSeconds(stamp))) publishAttitude(stamp, &tracker_.buffer());
  processQueue();
}

/// `attitudes`: null where the vehicle is taken to be level.
void ScanProjectorNode::publishAttitude(const ros::Time& stamp, const AttitudeBuffer* attitudes) {
  Attitude attitude;
  const double time = toSeconds(stamp);
  if (attitudes != nullptr && attitudes->lookup(time, attitude) != AttitudeError::kNone) return;
  attitude_publisher_.publish(stamp, attitude.stabilized_R_base, height_.height(time));
}

ProjectorReport ScanProjectorNode::report() const {
  ProjectorReport report;
  report.statistics = statistics_;
  report.topics = input_->topics();
  report.publishers = input_->publisherCount();
  report.waiting_for = waiting_for_;
  describeAttitude(report);
  height_.describe(report);
  return report;
}

void ScanProjectorNode::describeAttitude(ProjectorReport& report) const {
  const AttitudeBuffer& buffer = tracker_.buffer();
  Attitude attitude;
  const std::optional<double> latest = buffer.latest();
  if (latest && buffer.lookup(*latest, attitude) == AttitudeError::kNone) {
    report.tilt_rad = tiltOf(attitude.stabilized_R_base);
  }
  if (config_.isLevel()) {
    report.attitude_hint = "nowhere: the laser is taken to be level";
  } else if (config_.usesTf()) {
    report.attitude_hint = "tf " + config_.attitude_frame + " -> " + config_.base_frame;
    report.attitude_error = tf_error_;
  } else {
    report.imu = imu_->status();
    report.imu_topic = imu_->topic();
    report.imu_publishers = imu_->publisherCount();
    report.attitude_hint = "IMU on " + report.imu_topic;
    if (!imu_->waitingFor().empty()) {
      report.attitude_error = imu_->waitingFor();
    } else if (report.imu->health == ImuHealth::kNoData) {
      report.attitude_error = "no message on " + report.imu_topic + " yet" +
                              (report.imu_publishers == 0 ? " (nobody publishes it)" : "") +
                              ": scans are " +
                              (config_.without_imu == "level" ? "taken to be level" : "dropped") +
                              ". For a laser that is always level, set ~attitude_source to none";
    } else if (report.imu->health != ImuHealth::kOk) {
      report.attitude_error = report.imu->message;
    }
  }
}

}  // namespace kestrel
