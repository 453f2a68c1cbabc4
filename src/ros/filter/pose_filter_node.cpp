// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/filter/pose_filter_node.h"

#include <ros/console.h>

#include <cmath>
#include <exception>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/pipeline_messages.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/ros/common/guarded.h"
#include "kestrel_slam/ros/common/names.h"
#include "kestrel_slam/ros/common/wall_throttle.h"
#include "kestrel_slam/sensor/attitude_buffer.h"

namespace kestrel {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr std::uint32_t kImuQueue = 400;  // one second of a fast IMU
constexpr std::uint32_t kQueue = 20;
constexpr double kPeriod = 1.0;         // s
constexpr double kComplainEvery = 5.0;  // s
/// A pose with a stamp this close to a MapperState is treated as the same measurement, s.
constexpr double kSameMapper = 1.0;

/// Variance of an initial pose without covariance. Same values as the rviz tool "2D Pose Estimate".
const Eigen::Vector3d kPlacedVariance(0.25, 0.25, 0.07);  // m², rad²

int levelOf(FilterHealth health) {
  switch (health) {
    case FilterHealth::kOk:
      return DiagnosticStatus::OK;
    case FilterHealth::kCoasting:
    case FilterHealth::kInitializing:
      return DiagnosticStatus::WARN;
    default:
      return DiagnosticStatus::ERROR;
  }
}

std::string textOf(const Eigen::Vector3d& v) {
  char text[100];
  std::snprintf(text, sizeof text, "%.4f %.4f %.4f", v.x(), v.y(), v.z());
  return text;
}

void add(diagnostic_updater::DiagnosticStatusWrapper& status, const std::string& name,
         const SensorCounts& counts) {
  if (counts.received == 0) return;
  status.add(name + ": received", counts.received);
  status.add(name + ": used", counts.accepted);
  for (const auto& [reason, count] : counts.rejected) status.add(name + ": " + reason, count);
}

std::vector<OwnTransform> ownTransforms(const PoseFilterNodeConfig& config) {
  std::vector<OwnTransform> own;
  if (config.pub_map_odom_transform) {
    own.push_back({config.map_frame, config.odom_frame,
                   "Stop the other node, or set ~pub_map_odom_transform to false."});
  }
  if (config.pub_odom_base_transform) {
    own.push_back({config.odom_frame, config.base_footprint_frame,
                   "Stop the other node, or set ~pub_odom_base_transform to false."});
  }
  return own;
}

}  // namespace

PoseFilterNode::PoseFilterNode(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : config_(loadPoseFilterParameters(private_nh)),
      filter_(config_.filter),
      mountings_(nh, config_.base_frame, ownTransforms(config_)),
      range_mounting_(mountings_, config_.height_sensor_z),
      publisher_(nh, config_),
      updater_(nh, private_nh, private_nh.getNamespace()) {
  listen(nh);
  reset_server_ = nh.advertiseService("reset_filter", &PoseFilterNode::reset, this);
  updater_.setHardwareID(imu_subscriber_.getTopic());
  updater_.add("Pose filter",
               [this](diagnostic_updater::DiagnosticStatusWrapper& status) { report(status); });
  timer_ = nh.createSteadyTimer(ros::WallDuration(kPeriod), [this](const ros::SteadyTimerEvent&) {
    guarded("diagnostics", [this] { updater_.force_update(); });
  });
  ROS_INFO("Filtering %s; tf is %s -> %s -> %s.", imu_subscriber_.getTopic().c_str(),
           config_.map_frame.c_str(), config_.odom_frame.c_str(),
           config_.base_footprint_frame.c_str());
}

void PoseFilterNode::listen(ros::NodeHandle& nh) {
  using geometry_msgs::PoseWithCovarianceStamped;
  imu_subscriber_ = subscribeGuarded<sensor_msgs::Imu>(
      nh, config_.imu_topic, kImuQueue,
      [this](const sensor_msgs::ImuConstPtr& message) { onImu(message); },
      [this](const std::string& reason) { refuse("IMU messages", "implausible stamp", reason); });
  imu_watch_ = std::make_unique<SilenceWatch>(
      "IMU message",
      std::vector<NeededTopic>{
          {imu_subscriber_.getTopic(), ros::message_traits::datatype<sensor_msgs::Imu>()}},
      "~imu_topic");
  listen(nh, config_.mapper_topic, &PoseFilterNode::onMapperState);
  listen(nh, config_.pose_topic, &PoseFilterNode::onPose);
  listen(nh, config_.height_topic, &PoseFilterNode::onRange);
  listen(nh, config_.floor_height_topic, &PoseFilterNode::onRange);
  listen(nh, config_.pressure_topic, &PoseFilterNode::onPressure);
  listen(nh, config_.pressure_height_topic, &PoseFilterNode::onPressureHeight);
  listen(nh, config_.magnetometer_topic, &PoseFilterNode::onField);
  listen(nh, config_.fix_topic, &PoseFilterNode::onFix);
  subscribers_.push_back(subscribeGuarded<PoseWithCovarianceStamped>(
      nh, "initialpose", kQueue,
      [this](const PoseWithCovarianceStamped::ConstPtr& message) { onInitialPose(*message); }, {},
      Stamps::kIgnored));
}

template <typename Message>
void PoseFilterNode::listen(ros::NodeHandle& nh, const std::string& topic,
                            void (PoseFilterNode::*callback)(const Message&)) {
  if (topic.empty()) return;
  subscribers_.push_back(subscribeGuarded<Message>(
      nh, topic, kQueue,
      [this, callback](const boost::shared_ptr<const Message>& message) {
        (this->*callback)(*message);
      },
      [this, topic](const std::string& reason) {
        refuse("messages on " + topic, "implausible stamp", reason);
      }));
}

void PoseFilterNode::onImu(const sensor_msgs::ImuConstPtr& message) {
  const std::string frame = withoutSlash(message->header.frame_id);
  const std::optional<Eigen::Isometry3d> base_T_imu = mountings_.lookup(frame);
  if (!base_T_imu) {
    waiting_for_ = mountings_.missing("IMU", frame);
    refuse("IMU messages", "no transform", waiting_for_);
    return;
  }
  waiting_for_.clear();
  const ImuSample sample = toImuSample(*message);
  last_stamp_ = sample.stamp;
  since_last_ = WaitingTime();
  if (filter_.addImu(sample, *base_T_imu)) {
    publisher_.publish(message->header.stamp, *filter_.output(), filter_.imuRate());
  }
}

bool PoseFilterNode::isInMap(const std_msgs::Header& header, const char* what) {
  const std::string frame = clippedName(withoutSlash(header.frame_id));
  if (frame == config_.map_frame) return true;
  refuse(what, "not in the map frame",
         "the frame is '" + frame + "', but must be '" + config_.map_frame + "'");
  return false;
}

/// `reason` must be one of a fixed set, because the counts are kept by it; `why` may hold anything.
void PoseFilterNode::refuse(const std::string& what, const std::string& reason,
                            const std::string& why) {
  ++refused_[what + ": " + reason];
  last_refusal_ = what + ": " + why;
  KESTREL_WARN_THROTTLE(kComplainEvery, "Refused %s: %s.", what.c_str(), why.c_str());
}

/// MapperState also tells when the pose must not be used as a measurement.
void PoseFilterNode::onMapperState(const kestrel_slam::MapperState& message) {
  if (!isInMap(message.header, "mapper states")) return;
  const MatchedPose pose = fromMessage(message);
  mapper_stamp_ = pose.stamp;
  if (pose.state == MatchState::kLost) ++refused_["poses: the mapper is lost"];
  fuse(pose, filter_);
}

/// Ignores a pose if its MapperState was already used, so that it is not used twice.
void PoseFilterNode::onPose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  if (!isInMap(message.header, "poses")) return;
  if (std::abs(toSeconds(message.header.stamp) - mapper_stamp_) < kSameMapper) return;
  try {
    filter_.addPose({toSeconds(message.header.stamp), planarFromMessage(message.pose.pose),
                     planarCovariance(message.pose)});
  } catch (const std::invalid_argument& error) {
    refuse("poses", "invalid pose", error.what());
  }
}

/// A range finder on the vehicle measures along its tilted axis. A height in a level frame is
/// vertical.
void PoseFilterNode::onRange(const sensor_msgs::Range& message) {
  const std::string frame = withoutSlash(message.header.frame_id);
  if (frame == config_.base_stabilized_frame || frame == config_.base_footprint_frame) {
    filter_.addFloorHeight(toHeightSample(message, 0.0));
    return;
  }
  const std::optional<double> sensor_z = range_mounting_.sensorZ(frame);
  if (!sensor_z) return refuse("heights", "no mounting that looks down", range_mounting_.error());
  filter_.addRange(toHeightSample(message, *sensor_z));
}

void PoseFilterNode::onPressure(const sensor_msgs::FluidPressure& message) {
  filter_.addBarometer(toHeightSample(message));
}

void PoseFilterNode::onPressureHeight(const geometry_msgs::PointStamped& message) {
  filter_.addBarometer({toSeconds(message.header.stamp), message.point.z});
}

void PoseFilterNode::onField(const sensor_msgs::MagneticField& message) {
  const auto base_T_sensor = mountings_.lookup(withoutSlash(message.header.frame_id));
  const std::optional<FilterOutput>& output = filter_.output();
  if (!output) return;  // yaw from the magnetometer needs an attitude
  if (!base_T_sensor) {
    refuse("magnetometer", "no transform",
           mountings_.missing("magnetometer", withoutSlash(message.header.frame_id)));
    return;
  }
  const Eigen::Quaterniond tilt = withoutYaw(Eigen::Quaterniond(output->map_T_base.linear()));
  const auto yaw = toYaw(message, tilt * Eigen::Quaterniond(base_T_sensor->linear()),
                         config_.magnetic_declination);
  if (!yaw) return refuse("magnetometer", "no horizontal field", "it is vertical or zero");
  filter_.addYaw(*yaw);
}

void PoseFilterNode::onFix(const sensor_msgs::NavSatFix& message) {
  if (!filter_.output()) return;  // the first fix needs a filter state as reference
  const auto position = fixes_.toPosition(message, filter_.output()->map_T_base.translation());
  if (!position) return refuse("GPS fixes", "no position", "the message has no valid position");
  filter_.addPosition(*position);
}

void PoseFilterNode::onInitialPose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  if (!isInMap(message.header, "initialpose")) return;
  try {
    Eigen::Matrix3d covariance = planarCovariance(message.pose);
    if (covariance.isZero()) covariance = kPlacedVariance.asDiagonal();
    if (!filter_.setPose(planarFromMessage(message.pose.pose), covariance)) {
      refuse("initialpose", "invalid covariance", "the covariance is invalid");
    }
  } catch (const std::invalid_argument& error) {
    refuse("initialpose", "invalid pose", error.what());
  }
}

bool PoseFilterNode::reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  filter_.restart();
  fixes_.forget();
  response.success = true;
  response.message = "the filter restarts with the next IMU messages";
  ROS_INFO("reset_filter: %s.", response.message.c_str());
  return true;
}

std::string PoseFilterNode::imuSilence() {
  const double seconds = clockIsMissing() ? since_start_.wallSeconds() : since_start_.seconds();
  return imu_watch_->check(seconds, imu_subscriber_.getNumPublishers());
}

void PoseFilterNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const FilterStatus filter = filter_.status(now());
  status.summary(static_cast<unsigned char>(levelOf(filter.health)),
                 filter.message.empty() ? toString(filter.health) : filter.message);
  if (!waiting_for_.empty()) {
    status.summary(DiagnosticStatus::ERROR, waiting_for_);
  } else if (filter.imu.received == 0) {
    const std::string silence = imuSilence();
    if (!silence.empty()) status.summary(DiagnosticStatus::ERROR, silence);
  }
  status.add("health", toString(filter.health));
  status.add("IMU rate (Hz)", filter.imu_rate_hz);
  add(status, "imu", filter.imu);
  for (std::size_t i = 0; i < kFilterSensors; ++i) {
    add(status, toString(static_cast<FilterSensor>(i)), filter.sensors[i]);
  }
  for (const auto& [reason, count] : refused_) status.add("refused: " + reason, count);
  if (!last_refusal_.empty()) status.add("last refusal", last_refusal_);
  for (const auto& [reason, count] : filter.resets) status.add("resets: " + reason, count);
  status.add("jumps of the map", filter.reinitializations);
  status.add("started in the air", filter.started_in_air);
  if (const auto& output = filter_.output()) {
    status.add("bias of the gyro (rad/s)", textOf(output->gyro_bias));
    status.add("bias of the accelerometer (m/s²)", textOf(output->accelerometer_bias));
  }
}

}  // namespace kestrel
