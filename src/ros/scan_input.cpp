#include "kestrel_slam/ros/scan_input.h"

#include <ros/console.h>

#include <utility>

#include "kestrel_slam/ros/conversions.h"
#include "kestrel_slam/sensor/level_projector.h"
#include "kestrel_slam/tools/bag_transforms.h"

namespace kestrel_slam {
namespace {

constexpr std::uint32_t kWaitingScans = 50;  // that may wait for tf: more than a second of a laser
constexpr double kExplainAfter = 1.0;        // s of waiting before a message
constexpr double kComplainEvery = 5.0;       // s
// tf arrives on the thread of the scans: tf2 is not safe where a message filter asks for frames
// while another thread adds them.
constexpr bool kOwnTfThread = false;
constexpr double kRemindEvery = 60.0;  // s; of what goes on and on
// Stamps that jump back farther are those of a restarted recording, not of a late scan.
constexpr double kClockJump = 2.0;  // s

std::string publishHint(const std::string& parent, const std::string& child) {
  return "rosrun tf2_ros static_transform_publisher 0 0 0 0 0 0 " + parent + " " + child;
}

}  // namespace

ScanInput::ScanInput(ros::NodeHandle nh, const NodeConfig& config, ScanStatistics& statistics,
                     Callback on_ready)
    : config_(config),
      statistics_(statistics),
      on_ready_(std::move(on_ready)),
      listener_(buffer_, nh, kOwnTfThread),
      filter_(buffer_, config.base_frame, kWaitingScans, nh) {
  if (config.usesOdometry()) filter_.setTargetFrames({config.base_frame, config.odom_frame});
  filter_.registerCallback(&ScanInput::onReady, this);
  filter_.registerFailureCallback(
      [this](const sensor_msgs::LaserScanConstPtr& message, tf2_ros::FilterFailureReason reason) {
        onFailure(message, reason);
      });
  subscriber_ =
      nh.subscribe(config.scan_topic, static_cast<std::uint32_t>(config.scan_subscriber_queue_size),
                   &ScanInput::onScan, this, ros::TransportHints().tcpNoDelay());
}

void ScanInput::onScan(const sensor_msgs::LaserScanConstPtr& message) {
  statistics_.received();
  if (!acceptable(*message)) return;
  noticeJump(message->header.stamp);
  last_stamp_ = message->header.stamp;
  if (needsTransform(*message)) {
    filter_.add(message);
    explainWaiting(*message);
  } else {
    onReady(message);
  }
}

/// What must not get into the queue of the transforms; the projector looks at the rest.
bool ScanInput::acceptable(const sensor_msgs::LaserScan& message) {
  const std::size_t max_beams = static_cast<std::size_t>(config_.slam.beams.max_beams);
  if (message.ranges.size() > max_beams) {
    refuse(toString(ScanError::kTooManyBeams), "it has " + std::to_string(message.ranges.size()) +
                                                   " beams, ~max_beams allows " +
                                                   std::to_string(max_beams));
  } else if (withoutSlash(message.header.frame_id).empty()) {
    refuse("no-frame", "its frame_id is empty; the laser's driver has to set it");
  } else if (message.header.stamp.isZero()) {
    refuse(toString(ScanError::kBadStamp), "its stamp is zero; the laser's driver has to set it");
  } else if (message.header.stamp == last_stamp_) {
    refuse("repeated-stamp", "its stamp is that of the scan before (two publishers?)");
  } else {
    return true;
  }
  return false;
}

void ScanInput::refuse(const std::string& reason, const std::string& sentence) {
  statistics_.dropped(reason);
  ROS_WARN_THROTTLE(kComplainEvery, "A scan on %s is dropped: %s.", topic().c_str(),
                    sentence.c_str());
}

/// A recording that loops: what tf knows is of the future now and would hide all that comes.
void ScanInput::noticeJump(const ros::Time& stamp) {
  if (last_stamp_.isZero() || stamp + ros::Duration(kClockJump) >= last_stamp_) return;
  ROS_WARN(
      "The stamps of %s jump back by %.3f s (a recording that starts again?): tf is cleared, "
      "the map is kept, and the motion model starts anew.",
      topic().c_str(), (last_stamp_ - stamp).toSec());
  filter_.clear();
  buffer_.clear();
  ++epoch_;
}

/// tf2 knows no frame that nobody has published, not even its own identity.
bool ScanInput::needsTransform(const sensor_msgs::LaserScan& message) const {
  return config_.usesOdometry() || withoutSlash(message.header.frame_id) != config_.base_frame;
}

void ScanInput::explainWaiting(const sensor_msgs::LaserScan& message) {
  const ros::WallTime now = ros::WallTime::now();
  if (waiting_since_.isZero()) waiting_since_ = now;
  if ((now - waiting_since_).toSec() < kExplainAfter) return;
  const std::string text = missingTransform(message);
  statistics_.setWaitingFor(text);
  ROS_WARN_THROTTLE(kComplainEvery, "Scans on %s are waiting: %s", topic().c_str(), text.c_str());
}

/// Which transform is missing, and who should publish it.
std::string ScanInput::missingTransform(const sensor_msgs::LaserScan& message) const {
  const std::string laser = withoutSlash(message.header.frame_id);
  const std::string& base = config_.base_frame;
  std::string error;
  if (laser != base && !buffer_.canTransform(base, laser, message.header.stamp, &error)) {
    return "no transform from the laser's frame '" + laser + "' to the base frame '" + base +
           "' (" + error +
           "). The robot's description should publish it; for a laser that is the "
           "vehicle, set ~base_frame to '" +
           laser + "', else for example: " + publishHint(base, laser);
  }
  return "no transform from '" + base + "' to the odometry's frame '" + config_.odom_frame +
         "' at the time of the scan. The source of the odometry should publish it; without "
         "odometry, set ~odom_frame to ''";
}

void ScanInput::onReady(const sensor_msgs::LaserScanConstPtr& message) {
  if (!waiting_since_.isZero()) {
    waiting_since_ = ros::WallTime();
    statistics_.setWaitingFor("");
  }
  try {
    warnOfOtherParent(message->header.stamp);
    on_ready_(lookUp(message));
  } catch (const std::exception& error) {
    refuse("no-transform", error.what());
  }
}

/// Without odometry the node publishes map -> base; where somebody else publishes a parent of the
/// base too, tf jumps between the two.
void ScanInput::warnOfOtherParent(const ros::Time& stamp) const {
  std::string parent;
  if (config_.usesOdometry() || !config_.pub_map_odom_transform) return;
  if (!buffer_._getParent(config_.base_frame, stamp, parent) || parent == config_.map_frame) return;
  ROS_WARN_THROTTLE(kRemindEvery,
                    "tf has '%s' as parent of the base frame '%s', so '%s' cannot be its parent "
                    "too: if it is an odometry, set ~odom_frame to '%s'; else set ~base_frame to "
                    "the topmost frame of the vehicle.",
                    parent.c_str(), config_.base_frame.c_str(), config_.map_frame.c_str(),
                    parent.c_str());
}

ReadyScan ScanInput::lookUp(const sensor_msgs::LaserScanConstPtr& message) const {
  ReadyScan scan;
  scan.message = message;
  scan.epoch = epoch_;
  const std::string laser = withoutSlash(message->header.frame_id);
  const ros::Time& stamp = message->header.stamp;
  if (laser != config_.base_frame) {
    scan.base_T_laser =
        fromMessage(buffer_.lookupTransform(config_.base_frame, laser, stamp).transform);
  }
  if (config_.usesOdometry()) {
    scan.odom_T_base = toPose2(fromMessage(
        buffer_.lookupTransform(config_.odom_frame, config_.base_frame, stamp).transform));
  }
  return scan;
}

void ScanInput::onFailure(const sensor_msgs::LaserScanConstPtr& message,
                          tf2_ros::FilterFailureReason reason) {
  if (reason == tf2_ros::filter_failure_reasons::OutTheBack) {
    refuse("too-old", "tf has forgotten what was at its stamp " +
                          std::to_string(message->header.stamp.toSec()));
  } else {
    statistics_.dropped("no-transform");  // explainWaiting says why
  }
}

}  // namespace kestrel_slam
