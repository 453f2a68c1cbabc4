// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/tracker/tracker_node.h"

#include <ros/console.h>
#include <tf2/exceptions.h>

#include <exception>
#include <stdexcept>
#include <vector>

#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/planar_scan_message.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/messages/track_messages.h"
#include "kestrel_slam/ros/common/guarded.h"
#include "kestrel_slam/ros/common/wall_throttle.h"

namespace kestrel {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr std::uint32_t kQueue = 20;
/// A stamp that is older than the last one by more than this starts anew, s.
constexpr double kRestart = 1.0;
constexpr double kPatrolPeriod = 0.01;  // s; period of checking the waiting scans
constexpr double kReportPeriod = 1.0;   // s
constexpr double kComplainEvery = 5.0;  // s

}  // namespace

TrackerNode::TrackerNode(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : config_(loadTrackerParameters(private_nh)),
      tracker_(config_.tracker),
      transforms_(buffer_, nh),
      tracks_(nh.advertise<kestrel_slam::TrackArray>("tracks", kQueue)),
      markers_(nh.advertise<visualization_msgs::MarkerArray>("track_markers", kQueue)),
      points_(nh.advertise<sensor_msgs::PointCloud2>("moving_points", kQueue)),
      grid_(nh.advertise<nav_msgs::OccupancyGrid>("dynamic_grid", 1)),
      updater_(nh, private_nh, private_nh.getNamespace()) {
  subscriber_ = subscribeGuarded<kestrel_slam::PlanarScan>(
      nh, config_.scan_topic, kQueue,
      [this](const kestrel_slam::PlanarScanConstPtr& message) { onScan(message); },
      [this](const std::string& reason) { drop("implausible stamp", reason); });
  watch_ = std::make_unique<SilenceWatch>(
      "planar scan",
      std::vector<NeededTopic>{
          {subscriber_.getTopic(), ros::message_traits::datatype<kestrel_slam::PlanarScan>()}},
      "~scan_topic");
  updater_.setHardwareID(subscriber_.getTopic());
  updater_.add("Tracker",
               [this](diagnostic_updater::DiagnosticStatusWrapper& status) { report(status); });
  queue_timer_ = nh.createSteadyTimer(
      ros::WallDuration(kPatrolPeriod),
      [this](const ros::SteadyTimerEvent&) { guarded("tracker", [this] { processQueue(); }); });
  report_timer_ =
      nh.createSteadyTimer(ros::WallDuration(kReportPeriod), [this](const ros::SteadyTimerEvent&) {
        guarded("diagnostics", [this] { updater_.force_update(); });
      });
  ROS_INFO("Tracking what moves on %s; the tracks are in %s.", subscriber_.getTopic().c_str(),
           config_.odom_frame.c_str());
}

void TrackerNode::onScan(const kestrel_slam::PlanarScanConstPtr& message) {
  ++received_;
  since_last_ = WaitingTime();
  queue_.push_back({message, WaitingTime()});
  if (queue_.size() > kQueue) {
    queue_.pop_front();
    drop("overload", "more than " + std::to_string(kQueue) + " scans wait for their transform");
  }
  processQueue();
}

void TrackerNode::processQueue() {
  while (!queue_.empty() && handle(queue_.front())) queue_.pop_front();
}

/// True if the scan is finished (used or dropped).
bool TrackerNode::handle(const Waiting& scan) {
  const std::string frame = withoutSlash(scan.message->header.frame_id);
  try {
    const geometry_msgs::TransformStamped transform =
        buffer_.lookupTransform(config_.odom_frame, frame, scan.message->header.stamp);
    geometry_msgs::Pose pose;
    pose.position.x = transform.transform.translation.x;
    pose.position.y = transform.transform.translation.y;
    pose.orientation = transform.transform.rotation;
    track(*scan.message, planarFromMessage(pose));
  } catch (const tf2::TransformException& error) {
    if (scan.waiting.seconds() < config_.max_wait_s) return false;
    drop("no transform", "tf has no " + config_.odom_frame + " -> " + frame +
                             " at its time. Run mapper and pose filter, or set ~odom_frame");
  } catch (const std::exception& error) {
    drop("invalid scan", error.what());
  }
  return true;
}

void TrackerNode::track(const kestrel_slam::PlanarScan& message, const Pose2& odom_T_base) {
  PlanarScan scan = fromPlanarScanMessage(message);
  scan.time = scan.stamp;
  // A clock that goes back, as when a bag is played again.
  if (message.header.stamp + ros::Duration(kRestart) < last_stamp_) tracker_.reset();
  const Tracker::Result& result = tracker_.process(scan, odom_T_base);
  if (!result.used) return drop("not newer", "its stamp is not newer than that of the last scan");
  last_stamp_ = message.header.stamp;
  ++used_;
  if (result.saturated) {
    ++saturated_;
    saturated_lately_ = true;
  }
  publish(message, scan, odom_T_base);
}

void TrackerNode::publish(const kestrel_slam::PlanarScan& message, const PlanarScan& scan,
                          const Pose2& odom_T_base) {
  const ros::Time& stamp = message.header.stamp;
  const Tracker::Result& result = tracker_.result();
  const kestrel_slam::TrackArray tracks = toMessage(result, config_.odom_frame, stamp);
  shown_ = tracks.tracks.size();
  tracks_.publish(tracks);
  if (markers_.getNumSubscribers() > 0) markers_.publish(toMarkers(tracks));
  if (points_.getNumSubscribers() > 0) {
    std::vector<Eigen::Vector2f> points;
    for (std::size_t i = 0; i < scan.rays.size(); ++i) {
      if (!result.is_moving[i]) continue;
      points.emplace_back((odom_T_base * scan.rays[i].end.cast<double>()).cast<float>());
    }
    points_.publish(toCloud(points, config_.odom_frame, stamp));
  }
  publishGrid(stamp, odom_T_base.translation());
}

void TrackerNode::publishGrid(const ros::Time& stamp, const Eigen::Vector2d& center) {
  const bool is_due =
      stamp < last_grid_ || stamp - last_grid_ >= ros::Duration(config_.dynamic_grid_period);
  if (grid_.getNumSubscribers() == 0 || !is_due) return;
  last_grid_ = stamp;
  grid_.publish(
      toMessage(tracker_.grid(), center, config_.dynamic_grid_radius, config_.odom_frame, stamp));
}

void TrackerNode::drop(const std::string& reason, const std::string& why) {
  ++dropped_[reason];
  dropped_lately_ = true;
  last_drop_ = why;
  KESTREL_WARN_THROTTLE(kComplainEvery, "A planar scan is dropped: %s.", why.c_str());
}

void TrackerNode::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.summary(DiagnosticStatus::OK, "scans are tracked");
  if (saturated_lately_) {
    status.summary(DiagnosticStatus::WARN, "saturated: more objects than the tracker handles");
  }
  if (dropped_lately_) status.summary(DiagnosticStatus::WARN, "a scan was dropped: " + last_drop_);
  const double silent = received_ > 0 ? since_last_.seconds() : since_start_.seconds();
  const std::string silence = watch_->check(silent, subscriber_.getNumPublishers());
  if (!silence.empty()) status.summary(DiagnosticStatus::WARN, silence);
  dropped_lately_ = saturated_lately_ = false;
  status.add("received", received_);
  status.add("used", used_);
  for (const auto& [reason, count] : dropped_) status.add("dropped: " + reason, count);
  status.add("saturated scans", saturated_);
  status.add("moving objects", shown_);
}

}  // namespace kestrel
