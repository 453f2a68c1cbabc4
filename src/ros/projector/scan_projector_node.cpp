// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/scan_projector_node.h"

#include <ros/console.h>

#include <exception>
#include <utility>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/messages/sensor_messages.h"

namespace kestrel {
namespace {

constexpr double kPatrolPeriod = 0.01;  // s; period of checking the waiting sweeps
constexpr double kComplainEvery = 5.0;  // s
constexpr double kRemindEvery = 60.0;   // s; for problems that persist

ProjectionStageConfig projectionConfigOf(const ProjectorNodeConfig& config) {
  return {config.slam.projector, config.slam.attitude, config.isLevel(),
          config.without_imu == "level", config.max_wait_s};
}

}  // namespace

ScanProjectorNode::ScanProjectorNode(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : config_(loadProjectorParameters(private_nh)),
      projection_(projectionConfigOf(config_)),
      queue_(static_cast<std::size_t>(config_.queue_size)),
      mountings_(nh, config_.base_frame),
      tf_attitude_(mountings_.buffer(), config_.attitude_frame, config_.base_frame,
                   projection_.tracker()),
      filter_(nh, config_, projection_,
              [this](const ros::Time& stamp) {
                publishAttitude(stamp, &projection_.motions().attitude());
                processQueue();
              }),
      height_(nh, config_, mountings_, projection_),
      velocity_(nh, config_, projection_),
      scan_publisher_(nh, config_),
      attitude_publisher_(config_) {
  if (config_.usesImu()) {
    imu_ = std::make_unique<ImuInput>(nh, config_.imu_topic, mountings_, projection_,
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
  if (queue_.push(std::move(sweep))) {
    statistics_.drop("overload", "more than ~queue_size scans are waiting for their attitude");
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

/// True if the sweep is finished (projected or dropped).
bool ScanProjectorNode::handle(const Sweep& sweep) {
  const std::optional<Eigen::Isometry3d> base_T_laser = mountings_.lookup(sweep.frame);
  if (!base_T_laser) {
    waiting_for_ = mountings_.missing("laser", sweep.frame);
    if (sweep.waiting.seconds() < config_.max_wait_s) return false;
    drop(sweep, "no-transform", waiting_for_);
    return true;
  }
  waiting_for_.clear();
  const SweepDecision decision = judge(sweep);
  if (decision.kind == SweepDecision::kWait) return false;
  if (decision.kind == SweepDecision::kDrop) {
    drop(sweep, decision.reason, decision.message);
  } else {
    project(sweep, *base_T_laser, decision.kind == SweepDecision::kProjectLevel);
  }
  return true;
}

SweepDecision ScanProjectorNode::judge(const Sweep& sweep) {
  if (config_.usesTf()) return judgeTfAttitude(sweep);
  const double now = imu_ ? imu_->now() : 0.0;
  SweepDecision decision = projection_.judge(sweep.times, sweep.waiting.seconds(), now);
  if (decision.kind == SweepDecision::kDrop && imu_ && !imu_->waitingFor().empty()) {
    decision.reason = "imu-no-transform";
    decision.message = imu_->waitingFor();
  }
  return decision;
}

SweepDecision ScanProjectorNode::judgeTfAttitude(const Sweep& sweep) {
  if (tf_attitude_.fetch(sweep.times)) {
    tf_error_.clear();
    return {SweepDecision::kProject, "", ""};
  }
  if (sweep.waiting.seconds() < config_.max_wait_s) return {SweepDecision::kWait, "", ""};
  tf_error_ = tf_attitude_.missing();
  if (config_.without_imu == "level") return {SweepDecision::kProjectLevel, "", ""};
  return {SweepDecision::kDrop, "no-attitude-in-tf", tf_error_};
}

void ScanProjectorNode::project(const Sweep& sweep, const Eigen::Isometry3d& base_T_laser,
                                bool is_level) {
  const ProjectedSweep projected = projection_.project(sweep.data, base_T_laser, is_level);
  const Projection& projection = projected.projection;
  newest_ = toSeconds(sweep.stamp);
  scan_publisher_.publishHeights(sweep.stamp, projection);
  if (projection.error != ScanError::kNone) {
    drop(sweep, toString(projection.error), projection.message);
    return;
  }
  statistics_.warning = textOf(projection.warnings);
  if (!statistics_.warning.empty()) {
    ROS_WARN_THROTTLE(kRemindEvery, "Scans on %s are used, but %s.", sweep.topic.c_str(),
                      statistics_.warning.c_str());
  }
  ++statistics_.projected;
  if (projected.level) ++statistics_.projected_level;
  if (projected.filtered) ++statistics_.projected_filtered;
  statistics_.beams = projection.counts;
  scan_publisher_.publish(sweep.stamp, projection.scan);
  if (!imu_) publishAttitude(sweep.stamp, is_level ? nullptr : &projection_.tracker().buffer());
}

void ScanProjectorNode::drop(const Sweep& sweep, const std::string& reason,
                             const std::string& sentence) {
  statistics_.drop(reason, sentence);
  ROS_WARN_THROTTLE(kComplainEvery, "A scan on %s is dropped (%s): %s", sweep.topic.c_str(),
                    reason.c_str(), sentence.c_str());
}

void ScanProjectorNode::onAttitude(const ros::Time& stamp) {
  if (!projection_.motions().runs(toSeconds(stamp))) {
    publishAttitude(stamp, &projection_.tracker().buffer());
  }
  processQueue();
}

/// `attitudes`: null if the vehicle is assumed to be level.
void ScanProjectorNode::publishAttitude(const ros::Time& stamp, const AttitudeBuffer* attitudes) {
  Attitude attitude;
  const double time = toSeconds(stamp);
  if (attitudes != nullptr && attitudes->lookup(time, attitude) != AttitudeError::kNone) return;
  attitude_publisher_.publish(stamp, attitude.stabilized_R_base,
                              projection_.heights().height(time));
}

ProjectorReport ScanProjectorNode::report() const {
  ProjectorReport report;
  report.statistics = statistics_;
  report.topics = input_->topics();
  report.publishers = input_->publisherCount();
  report.waiting_for = waiting_for_;
  describeAttitude(report);
  height_.describe(newest_, report);
  return report;
}

void ScanProjectorNode::describeAttitude(ProjectorReport& report) const {
  const AttitudeBuffer& buffer = projection_.tracker().buffer();
  Attitude attitude;
  const std::optional<double> latest = buffer.latest();
  if (latest && buffer.lookup(*latest, attitude) == AttitudeError::kNone) {
    report.tilt_rad = tiltOf(attitude.stabilized_R_base);
  }
  if (config_.isLevel()) {
    report.attitude_hint = "none: the laser is assumed to be level";
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
                              (config_.without_imu == "level" ? "assumed to be level" : "dropped") +
                              ". For a laser that is always level, set ~attitude_source to none";
    } else if (report.imu->health != ImuHealth::kOk) {
      report.attitude_error = report.imu->message;
    }
  }
}

}  // namespace kestrel
