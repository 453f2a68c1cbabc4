// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/scan_projector_node.h"

#include <ros/console.h>

#include <cmath>
#include <exception>
#include <utility>
#include <vector>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/ros/common/wall_throttle.h"

namespace kestrel {
namespace {

constexpr double kPatrolPeriod = 0.01;  // s; period of checking the waiting sweeps
constexpr double kComplainEvery = 5.0;  // s
constexpr double kHour = 3600.0;        // s
constexpr double kRemindEvery = 60.0;   // s; for problems that persist

ProjectionStageConfig projectionConfigOf(const ProjectorNodeConfig& config) {
  return {config.slam.projector, config.slam.attitude, config.isLevel(),
          config.without_imu == "level", config.max_wait_s};
}

std::vector<OwnTransform> ownTransforms(const ProjectorNodeConfig& config) {
  std::vector<OwnTransform> own;
  if (config.publishesStabilized()) {
    own.push_back({config.base_stabilized_frame, config.base_frame,
                   "Stop the other one, or set ~base_frame to the topmost frame of the vehicle."});
  }
  if (config.pub_footprint_transform) {
    own.push_back({config.base_footprint_frame, config.base_stabilized_frame,
                   "Stop the other node, or set ~pub_footprint_transform to false."});
  }
  return own;
}

}  // namespace

ScanProjectorNode::ScanProjectorNode(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : config_(loadProjectorParameters(private_nh)),
      live_config_(config_),
      projection_(projectionConfigOf(config_)),
      queue_(static_cast<std::size_t>(config_.queue_size)),
      mountings_(nh, config_.base_frame, ownTransforms(config_)),
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
      nh, private_nh, input_->neededTopics(), imuTopics(),
      [this] {
        sayProblems();
        return report();
      },
      [this] { statistics_.dropped_lately = 0; });
  timer_ = nh.createSteadyTimer(ros::WallDuration(kPatrolPeriod),
                                [this](const ros::SteadyTimerEvent&) { processQueue(); });
  live_parameters_ =
      std::make_unique<LiveParameters>(private_nh, parametersOf(live_config_), [this] {
        validate(live_config_.slam);
        projection_.configure(live_config_.slam.projector);
      });
  ProjectorReport start;
  describeAttitude(start);
  ROS_INFO("Projecting %s; attitude from %s.", input_->topics().c_str(),
           start.attitude_hint.c_str());
}

std::vector<NeededTopic> ScanProjectorNode::imuTopics() const {
  if (!imu_) return {};
  return {{imu_->topic(), ros::message_traits::datatype<sensor_msgs::Imu>()}};
}

void ScanProjectorNode::enqueue(Sweep sweep) {
  if (queue_.push(std::move(sweep))) {
    statistics_.drop("overload", "more than ~queue_size scans are waiting for their attitude");
  }
  processQueue();
}

void ScanProjectorNode::processQueue() {
  const auto handleSafely = [this](const Sweep& sweep) {
    try {
      return handle(sweep);
    } catch (const std::exception& error) {
      drop(sweep, "internal-error", error.what());
      return true;
    }
  };
  queue_.process(handleSafely, [](const Sweep& sweep) { return sweep.frame; });
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
  } else if (decision.kind == SweepDecision::kDrop && imu_ &&
             imu_->hasOtherClock(sweep.times.last)) {
    decision.reason = "other-clock";
    decision.message = "laser and IMU have different clocks (" +
                       std::to_string(std::lround((sweep.times.last - now) / kHour)) +
                       " hours apart); set the clock of the drivers";
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
    KESTREL_WARN_THROTTLE(kRemindEvery, "Scans on %s are used, but %s.", sweep.topic.c_str(),
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
  KESTREL_WARN_THROTTLE(kComplainEvery, "A scan on %s is dropped (%s): %s", sweep.topic.c_str(),
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
    } else if (!report.imu->message.empty()) {
      report.attitude_error = report.imu->message;
    }
  }
  const std::vector<ImuFault> problems = projection_.problems(imu_ ? imu_->now() : newest_);
  if (report.attitude_error.empty() && !problems.empty()) {
    report.attitude_error = problems.front().message;
  }
  for (const ImuFault& problem : problems) report.problems.push_back(problem.message);
}

/// Says each problem once; the diagnostics repeat the first one.
void ScanProjectorNode::sayProblems() {
  for (const ImuFault& problem : projection_.problems(imu_ ? imu_->now() : newest_)) {
    if (said_.insert(problem.reason).second) ROS_WARN("Attitude: %s", problem.message.c_str());
  }
}

}  // namespace kestrel
