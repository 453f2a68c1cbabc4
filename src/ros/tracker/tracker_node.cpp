// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/tracker/tracker_node.h"

#include <ros/console.h>
#include <tf2/exceptions.h>

#include <algorithm>
#include <cctype>
#include <exception>
#include <type_traits>
#include <utility>

#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/messages/track_messages.h"
#include "kestrel_slam/ros/common/guarded.h"

namespace kestrel {
namespace {

using diagnostic_msgs::DiagnosticStatus;
using ScanMessage = kestrel_slam::PlanarScan;
using sensor_msgs::PointCloud2;

constexpr std::uint32_t kQueue = 20;
/// Clouds that wait: a tracker that is too slow skips clouds rather than being late.
constexpr std::uint32_t kCloudQueue = 3;
constexpr double kPatrolPeriod = 0.005;  // s; period of checking what waits
constexpr double kReportPeriod = 1.0;    // s
constexpr double kComplainEvery = 30.0;  // s, for each problem
constexpr std::size_t kMostProblems = 100;

}  // namespace

TrackerNode::TrackerNode(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : config_(loadTrackerParameters(private_nh)),
      scans_(config_.tracker, config_.odom_frame),
      clouds_(config_.cloud, config_.odom_frame),
      transforms_(buffer_, nh),
      tracks_(nh.advertise<kestrel_slam::TrackArray>("tracks", kQueue)),
      markers_(nh.advertise<visualization_msgs::MarkerArray>("track_markers", kQueue)),
      points_(nh.advertise<PointCloud2>("moving_points", kQueue)),
      grid_(nh.advertise<nav_msgs::OccupancyGrid>("dynamic_grid", 1)),
      updater_(nh, private_nh, private_nh.getNamespace()) {
  std::vector<NeededTopic> needed;
  const auto note = [&](const std::string& topic, const char* type) {
    needed.push_back({nh.resolveName(topic), type});
  };
  if (config_.takesScans()) {
    subscribe<ScanMessage>(nh, config_.scan_topic);
    note(config_.scan_topic, ros::message_traits::datatype<ScanMessage>());
  }
  if (config_.takesClouds()) {
    subscribe<PointCloud2>(nh, config_.cloud_topic);
    note(config_.cloud_topic, ros::message_traits::datatype<PointCloud2>());
  }
  std::string topics;
  for (const NeededTopic& topic : needed) topics += (topics.empty() ? "" : ", ") + topic.name;
  watch_ = std::make_unique<SilenceWatch>("planar scan or cloud", needed,
                                          config_.takesScans() ? "~scan_topic" : "~cloud_topic");
  updater_.setHardwareID(topics);
  updater_.add("Tracker",
               [this](diagnostic_updater::DiagnosticStatusWrapper& status) { report(status); });
  queue_timer_ = nh.createSteadyTimer(
      ros::WallDuration(kPatrolPeriod),
      [this](const ros::SteadyTimerEvent&) { guarded("tracker", [this] { processQueue(); }); });
  report_timer_ =
      nh.createSteadyTimer(ros::WallDuration(kReportPeriod), [this](const ros::SteadyTimerEvent&) {
        guarded("diagnostics", [this] { updater_.force_update(); });
      });
  ROS_INFO("Tracking what moves on %s; the tracks are in %s.", topics.c_str(),
           config_.odom_frame.c_str());
}

template <typename Message>
void TrackerNode::subscribe(ros::NodeHandle nh, const std::string& topic) {
  constexpr bool kIsCloud = std::is_same_v<Message, PointCloud2>;
  subscribers_[kIsCloud] = subscribeGuarded<Message>(
      nh, topic, kIsCloud ? kCloudQueue : kQueue,
      [this](const boost::shared_ptr<const Message>& message) {
        choose(kIsCloud);
        if (accept(message->header)) onMessage(message);
      },
      [this](const std::string& reason) { drop("implausible stamp", reason); });
}

/// The first message decides what is tracked.
void TrackerNode::choose(bool clouds) {
  if (input_ != Input::kUndecided) return;
  input_ = clouds ? Input::kClouds : Input::kScans;
  subscribers_.erase(!clouds);
  ROS_INFO("Tracking with %s.", clouds ? "the clouds of a 3D lidar" : "planar scans");
}

bool TrackerNode::accept(const std_msgs::Header& header) {
  ++received_;
  since_last_ = WaitingTime();
  if (header.stamp.isZero()) {
    drop("no stamp", "its stamp is zero; the driver must set it");
  } else if (withoutSlash(header.frame_id).empty()) {
    drop("no frame", "its frame_id is empty; the driver must set it");
  } else {
    return true;
  }
  return false;
}

void TrackerNode::onMessage(const boost::shared_ptr<const ScanMessage>& message) {
  push({message->header,
        [this, message](const Eigen::Isometry3d& odom_T_base) {
          return scans_.follow(*message, odom_T_base);
        },
        WaitingTime()},
       kQueue);
  processQueue();
}

/// Clouds are tracked by the timer, so that those that arrive meanwhile are counted if they must be
/// dropped.
void TrackerNode::onMessage(const boost::shared_ptr<const PointCloud2>& message) {
  push({message->header,
        [this, message](const Eigen::Isometry3d& reference_T_lidar) {
          if (!config_.cloud_odometry) return clouds_.follow(*message, reference_T_lidar);
          Followed followed = clouds_.followAlone(*message, reference_T_lidar);
          if (followed.used) publishOdometry(message->header, reference_T_lidar);
          return followed;
        },
        WaitingTime()},
       kCloudQueue);
}

void TrackerNode::push(Waiting data, std::size_t most) {
  queue_.push_back(std::move(data));
  if (queue_.size() <= most) return;
  queue_.pop_front();
  drop("overload", "more than " + std::to_string(most) +
                       " wait, because tracking is too slow or transforms are late");
}

void TrackerNode::processQueue() {
  while (!queue_.empty() && handle(queue_.front())) {
    queue_.pop_front();
    if (input_ == Input::kClouds) return;
  }
}

/// The frame in which the sensor's pose must be known.
const std::string& TrackerNode::referenceFrame(const std::string& frame) const {
  if (input_ != Input::kClouds || !config_.cloud_odometry) return config_.odom_frame;
  return config_.base_frame.empty() ? frame : config_.base_frame;
}

/// True if the scan or cloud is finished (used or dropped).
bool TrackerNode::handle(const Waiting& data) {
  const std::string frame = withoutSlash(data.header.frame_id);
  const std::string& reference = referenceFrame(frame);
  try {
    Eigen::Isometry3d reference_T_sensor = Eigen::Isometry3d::Identity();
    if (reference != frame) {
      reference_T_sensor =
          fromMessage(buffer_.lookupTransform(reference, frame, data.header.stamp).transform);
    }
    finish(data.header, data.follow(reference_T_sensor));
  } catch (const tf2::TransformException& error) {
    if (data.waiting.seconds() < config_.max_wait_s) return false;
    drop("no transform",
         "tf has no " + reference + " -> " + frame + " at its time. " +
             (config_.cloud_odometry ? "Publish it, or set ~base_frame"
                                     : "Run mapper and pose filter, or set ~odom_frame"));
  } catch (const std::exception& error) {
    drop("invalid", error.what());
  }
  return true;
}

void TrackerNode::finish(const std_msgs::Header& header, const Followed& followed) {
  if (!followed.used) return drop("not usable", followed.problem);
  ++used_;
  if (followed.saturated) {
    ++saturated_;
    saturated_lately_ = true;
  }
  if (input_ == Input::kClouds && !clouds_.isLocalized()) ++unlocalized_;
  if (!followed.problem.empty()) {
    limit_ = followed.problem;
    if (isNews(limit_)) ROS_WARN("Tracking is limited: %s.", limit_.c_str());
  }
  if (followed.note != note_) {
    note_ = followed.note;
    if (!note_.empty()) ROS_WARN("%s", note_.c_str());
  }
  publish(followed);
  publishGrid(header.stamp);
}

void TrackerNode::publish(const Followed& followed) {
  shown_ = followed.tracks.tracks.size();
  tracks_.publish(followed.tracks);
  if (markers_.getNumSubscribers() > 0) markers_.publish(toMarkers(followed.tracks));
  if (points_.getNumSubscribers() > 0) {
    points_.publish(
        toCloud(followed.moving_points, config_.odom_frame, followed.tracks.header.stamp));
  }
}

/// A pose that is only predicted is not published.
void TrackerNode::publishOdometry(const std_msgs::Header& header,
                                  const Eigen::Isometry3d& base_T_lidar) {
  if (!clouds_.isLocalized()) return;
  geometry_msgs::TransformStamped transform;
  transform.transform = toTransformMessage(clouds_.pose() * base_T_lidar.inverse());
  transform.header.stamp = header.stamp;
  transform.header.frame_id = config_.odom_frame;
  transform.child_frame_id = referenceFrame(withoutSlash(header.frame_id));
  broadcaster_.sendTransform(transform);
}

void TrackerNode::publishGrid(const ros::Time& stamp) {
  const bool is_due =
      stamp < last_grid_ || stamp - last_grid_ >= ros::Duration(config_.dynamic_grid_period);
  if (grid_.getNumSubscribers() == 0 || !is_due) return;
  last_grid_ = stamp;
  const double radius = config_.dynamic_grid_radius;
  grid_.publish(input_ == Input::kClouds ? clouds_.grid(radius, stamp)
                                         : scans_.grid(radius, stamp));
}

void TrackerNode::drop(const std::string& reason, const std::string& why) {
  ++dropped_[reason];
  last_drop_ = why;
  if (!isNews(why)) return;
  ROS_WARN("A %s is dropped: %s.", input_ == Input::kClouds ? "cloud" : "planar scan", why.c_str());
}

/// Each problem is logged when it appears, and then rarely. Its numbers may differ.
bool TrackerNode::isNews(std::string problem) {
  problem.erase(std::remove_if(problem.begin(), problem.end(),
                               [](unsigned char c) { return std::isdigit(c) != 0; }),
                problem.end());
  if (throttles_.size() > kMostProblems) throttles_.clear();
  return throttles_.try_emplace(problem, kComplainEvery).first->second.due();
}

unsigned TrackerNode::publisherCount() const {
  unsigned count = 0;
  for (const auto& [is_cloud, subscriber] : subscribers_) count += subscriber.getNumPublishers();
  return count;
}

void TrackerNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const bool clouds = input_ == Input::kClouds;
  status.summary(DiagnosticStatus::OK, clouds ? "clouds are tracked" : "scans are tracked");
  if (!limit_.empty()) status.summary(DiagnosticStatus::WARN, limit_);
  if (saturated_lately_) {
    status.summary(DiagnosticStatus::WARN, "saturated: more objects than the tracker handles");
  }
  if (!last_drop_.empty()) {
    status.summary(DiagnosticStatus::WARN,
                   (clouds ? "a cloud" : "a scan") + std::string(" was dropped: ") + last_drop_);
  }
  const double silent = received_ > 0 ? since_last_.seconds() : since_start_.seconds();
  const std::string silence = watch_->check(silent, publisherCount());
  if (!silence.empty()) status.summary(DiagnosticStatus::WARN, silence);
  last_drop_.clear();
  limit_.clear();
  saturated_lately_ = false;
  status.add("received", received_);
  status.add("used", used_);
  for (const auto& [reason, count] : dropped_) status.add("dropped: " + reason, count);
  status.add("saturated scans", saturated_);
  if (clouds) status.add("clouds without localization", unlocalized_);
  status.add("moving objects", shown_);
}

}  // namespace kestrel
