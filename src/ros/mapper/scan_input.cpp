// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/scan_input.h"

#include <ros/console.h>
#include <tf2_msgs/TF2Error.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/ros/common/guarded.h"
#include "kestrel_slam/ros/common/names.h"
#include "kestrel_slam/ros/common/stamps.h"
#include "kestrel_slam/ros/common/wall_throttle.h"
#include "kestrel_slam/sensor/projection.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kWaitingScans = 50;  // may wait for tf; more than one second of scans
constexpr double kExplainAfter = 1.0;        // s; waiting time before a warning
constexpr double kComplainEvery = 5.0;       // s
// A larger jump back means that a recording was restarted, not that a scan is late.
constexpr std::size_t kMostFrames = 32;  // more are garbage
constexpr double kClockJump = 2.0;       // s
constexpr double kRemindEvery = 30.0;    // s; for problems that persist
constexpr double kHour = 3600.0;         // s
constexpr double kOtherClock = kHour;    // late tf is late by seconds

std::string publishHint(const std::string& parent, const std::string& child) {
  return "rosrun tf2_ros static_transform_publisher 0 0 0 0 0 0 " + parent + " " + child;
}

/// The transforms that the mapper publishes.
std::vector<OwnTransform> ownTransforms(const MapperNodeConfig& config) {
  std::vector<OwnTransform> own;
  if (config.pub_map_odom_transform && config.usesOdometry()) {
    own.push_back({config.map_frame, config.odom_frame,
                   "Stop the other node, or set ~pub_map_odom_transform to false."});
  } else if (config.pub_map_odom_transform) {
    own.push_back({config.map_frame, config.base_frame,
                   "If it is an odometry, set ~odom_frame to its parent frame; else set "
                   "~base_frame to the topmost frame of the vehicle."});
  }
  if (config.pub_map_scanmatch_transform) {
    own.push_back({config.map_frame, config.tf_map_scanmatch_transform_frame_name,
                   "Set ~tf_map_scanmatch_transform_frame_name to another name."});
  }
  return own;
}

}  // namespace

ScanInput::ScanInput(ros::NodeHandle nh, const MapperNodeConfig& config, ScanStatistics& statistics,
                     Callback on_ready)
    : config_(config),
      statistics_(statistics),
      on_ready_(std::move(on_ready)),
      transforms_(buffer_, nh, ownTransforms(config)),
      filter_(buffer_, config.base_frame, kWaitingScans, nh) {
  if (config.usesOdometry()) filter_.setTargetFrames({config.base_frame, config.odom_frame});
  filter_.registerCallback(&ScanInput::onReady, this);
  filter_.registerFailureCallback(
      [this](const ReceivedScanPtr& scan, tf2_ros::FilterFailureReason reason) {
        onFailure(scan, reason);
      });
  const auto queue = static_cast<std::uint32_t>(config.scan_subscriber_queue_size);
  const Refuse refuse_stamp = [this](const std::string& reason) {
    statistics_.received();
    refuse(toString(ScanError::kBadStamp), reason);
  };
  if (config.usesPlanarScans()) {
    subscriber_ = subscribeGuarded<kestrel_slam::PlanarScan>(
        nh, config.inputTopic(), queue,
        [this](const kestrel_slam::PlanarScanConstPtr& message) { onPlanarScan(message); },
        refuse_stamp);
  } else {
    subscriber_ = subscribeGuarded<sensor_msgs::LaserScan>(
        nh, config.inputTopic(), queue,
        [this](const sensor_msgs::LaserScanConstPtr& message) { onLaserScan(message); },
        refuse_stamp);
  }
}

NeededTopic ScanInput::neededTopic() const {
  return {topic(), config_.usesPlanarScans()
                       ? ros::message_traits::datatype<kestrel_slam::PlanarScan>()
                       : ros::message_traits::datatype<sensor_msgs::LaserScan>()};
}

void ScanInput::onLaserScan(const sensor_msgs::LaserScanConstPtr& message) {
  const std_msgs::Header& header = message->header;
  receive({{message, nullptr}, withoutSlash(header.frame_id), header.stamp},
          message->ranges.size());
}

/// The frame of a planar scan has the position and yaw of the base. Only the odometry is needed
/// from tf, and it is published for the base.
void ScanInput::onPlanarScan(const kestrel_slam::PlanarScanConstPtr& message) {
  receive({{nullptr, message}, config_.base_frame, message->header.stamp}, message->hit.size());
}

/// Two lasers on one topic may have equal stamps.
bool ScanInput::isRepeated(const ReceivedScan& scan) const {
  const auto last = last_stamps_.find(scan.frame);
  return last != last_stamps_.end() && last->second == scan.stamp;
}

void ScanInput::receive(const ReceivedScan& scan, std::size_t beams) {
  statistics_.received();
  if (!acceptable(scan, beams)) return;
  noticeJump(scan.stamp);
  if (last_stamps_.size() >= kMostFrames) last_stamps_.clear();
  last_stamp_ = last_stamps_[scan.frame] = scan.stamp;
  const bool other_clock = hasOtherClock(scan);
  if (!needsTransform(scan) || (other_clock && !config_.usesOdometry())) return handOver(scan);
  ReceivedScan waiting = scan;
  if (other_clock) waiting.frame = config_.base_frame;  // waits only for the odometry
  filter_.add(boost::make_shared<const ReceivedScan>(waiting));
  explainWaiting(scan);
}

/// Checks what must hold before a scan waits for its transforms. The matching thread does the other
/// checks. Planar scans of several lasers may have the same stamp.
bool ScanInput::acceptable(const ReceivedScan& scan, std::size_t beams) {
  const std::size_t max_beams = static_cast<std::size_t>(config_.slam.projector.beams.max_beams);
  if (beams > max_beams) {
    refuse(toString(ScanError::kTooManyBeams), "it has " + std::to_string(beams) +
                                                   " beams, ~max_beams allows " +
                                                   std::to_string(max_beams));
  } else if (scan.frame.empty()) {
    refuse("no-frame", "its frame_id is empty; the laser driver must set it");
  } else if (scan.stamp.isZero()) {
    refuse(toString(ScanError::kBadStamp), "its stamp is zero; the laser driver must set it");
  } else if (isRepeated(scan) && !config_.usesPlanarScans()) {
    refuse("repeated-stamp", "its stamp equals that of the previous scan (two publishers?)");
  } else {
    return true;
  }
  return false;
}

void ScanInput::refuse(const std::string& reason, const std::string& sentence) {
  statistics_.dropped(reason);
  KESTREL_WARN_THROTTLE(kComplainEvery, "A scan on %s is dropped: %s.", topic().c_str(),
                        sentence.c_str());
}

/// Handles a recording that starts again. The old data in tf are now in the future and would hide
/// new data.
void ScanInput::noticeJump(const ros::Time& stamp) {
  const double jump = secondsBetween(stamp, last_stamp_);
  if (last_stamp_.isZero() || jump <= kClockJump) return;
  ROS_WARN(
      "The stamps of %s jump back by %.3f s (did a recording start again?): tf is cleared, "
      "the map is kept, and the motion model is reset.",
      topic().c_str(), jump);
  filter_.clear();
  buffer_.clear();
  ++epoch_;
}

/// tf2 rejects frames that were never published, even for an identity transform.
bool ScanInput::needsTransform(const ReceivedScan& scan) const {
  return config_.usesOdometry() || scan.frame != config_.base_frame;
}

/// The frame whose mounting is needed; the base frame for planar scans.
std::string ScanInput::laserFrameOf(const ReceivedScan& scan) const {
  const sensor_msgs::LaserScanConstPtr& message = scan.message.laser_scan;
  return message ? withoutSlash(message->header.frame_id) : config_.base_frame;
}

/// Whether the stamps of scans and of the mounting in tf come from different clocks, for example
/// one since boot. A rigid mounting needs no time, so it is used as it is. Odometry needs one
/// clock.
bool ScanInput::hasOtherClock(const ReceivedScan& scan) const {
  const double apart = clocksApart(config_.base_frame, laserFrameOf(scan), scan.stamp);
  if (std::abs(apart) < kOtherClock) return false;
  KESTREL_WARN_THROTTLE(
      kRemindEvery,
      "Scans and tf have different clocks (%.1f hours apart). The mounting is used "
      "as it is; set the clock of the laser driver.",
      apart / kHour);
  return true;
}

/// Seconds from the newest transform between two frames to `stamp`; 0 if tf has none, or a static
/// one.
double ScanInput::clocksApart(const std::string& a, const std::string& b,
                              const ros::Time& stamp) const {
  ros::Time newest;
  const auto target = buffer_._lookupFrameNumber(a);
  const auto source = buffer_._lookupFrameNumber(b);
  if (target == 0 || source == 0) return 0.0;
  const int error = buffer_._getLatestCommonTime(target, source, newest, nullptr);
  return error == tf2_msgs::TF2Error::NO_ERROR && !newest.isZero() ? secondsBetween(newest, stamp)
                                                                   : 0.0;
}

void ScanInput::explainWaiting(const ReceivedScan& scan) {
  const ros::WallTime now = ros::WallTime::now();
  if (waiting_since_.isZero()) waiting_since_ = now;
  if ((now - waiting_since_).toSec() < kExplainAfter) return;
  const std::string text = missingTransform(scan);
  statistics_.setWaitingFor(text);
  KESTREL_WARN_THROTTLE(kRemindEvery, "Scans on %s are waiting: %s", topic().c_str(), text.c_str());
}

/// Describes the missing transform and who should publish it.
std::string ScanInput::missingTransform(const ReceivedScan& scan) const {
  const std::string& laser = scan.frame;
  const std::string& base = config_.base_frame;
  const double apart =
      config_.usesOdometry() ? clocksApart(base, config_.odom_frame, scan.stamp) : 0.0;
  if (std::abs(apart) >= kOtherClock) {
    return "scans and odometry have different clocks (" +
           std::to_string(std::lround(apart / kHour)) +
           " hours apart). Set the clock of the driver";
  }
  if (laser != base && !buffer_.canTransform(base, laser, scan.stamp)) {
    const std::string name = clippedName(laser);
    return "no transform from the laser's frame '" + name + "' to the base frame '" + base +
           "'. Publish it (" + publishHint(base, name) + "), or set ~base_frame to '" + name + "'";
  }
  if (config_.slam.mapper.known_poses) {
    return "no transform from '" + config_.odom_frame + "' to '" + base +
           "' at the time of the scan. ~map_with_known_poses needs it; for the poses of an "
           "odometry, set ~odom_frame";
  }
  return "no transform from '" + base + "' to the odometry's frame '" + config_.odom_frame +
         "' at the time of the scan. Its source should publish it; without odometry, set "
         "~odom_frame to ''";
}

void ScanInput::onReady(const ReceivedScanPtr& scan) { handOver(*scan); }

void ScanInput::handOver(const ReceivedScan& scan) {
  if (!waiting_since_.isZero()) {
    waiting_since_ = ros::WallTime();
    statistics_.setWaitingFor("");
  }
  try {
    on_ready_(lookUp(scan));
  } catch (const std::exception& error) {
    refuse("no-transform", error.what());
  }
}

ReadyScan ScanInput::lookUp(const ReceivedScan& scan) const {
  ReadyScan ready;
  ready.message = scan.message;
  ready.stamp = scan.stamp;
  ready.epoch = epoch_;
  const std::string& base = config_.base_frame;
  const std::string laser = laserFrameOf(scan);
  if (laser != base) {
    const ros::Time time = hasOtherClock(scan) ? ros::Time() : scan.stamp;  // zero: the newest
    ready.base_T_laser = fromMessage(buffer_.lookupTransform(base, laser, time).transform);
  }
  if (config_.usesOdometry()) {
    ready.odom_T_base = toPose2(
        fromMessage(buffer_.lookupTransform(config_.odom_frame, base, scan.stamp).transform));
  }
  return ready;
}

void ScanInput::onFailure(const ReceivedScanPtr& scan, tf2_ros::FilterFailureReason reason) {
  if (reason == tf2_ros::filter_failure_reasons::OutTheBack) {
    refuse("too-old", "tf has no more data at its stamp " + std::to_string(scan->stamp.toSec()));
  } else {
    statistics_.dropped("no-transform");  // explainWaiting logs the reason
  }
}

}  // namespace kestrel
