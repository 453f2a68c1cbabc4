#include "kestrel_slam/tools/bag_recording.h"

#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>

#include <optional>
#include <set>
#include <stdexcept>

#include "kestrel_slam/tools/bag_odometry.h"
#include "kestrel_slam/tools/bag_scan.h"
#include "kestrel_slam/tools/bag_structure.h"
#include "kestrel_slam/tools/bag_topics.h"
#include "kestrel_slam/tools/bag_transforms.h"

namespace kestrel_slam {
namespace {

const std::string kScanType = "sensor_msgs/LaserScan";
const std::string kOdometryType = "nav_msgs/Odometry";

void openBag(rosbag::Bag& bag, const std::string& path) {
  const std::string advice = "; repair it with `rosbag reindex " + path + "`";
  try {
    checkBagStructure(path);
    bag.open(path, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw std::runtime_error(path + ": the bag has no index (its recording was cut off)" + advice);
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": is no usable bag: " + error.what() + advice);
  }
}

/// The highest frame above the laser that is still part of the vehicle.
std::string vehicleFrameAbove(const BagTransforms& transforms, const std::string& laser_frame) {
  static const std::set<std::string> kWorldFrames = {"map",           "world", "odom",
                                                     "odom_combined", "mocap", "earth"};
  std::string base = laser_frame;
  for (const std::string& frame : transforms.ancestors(laser_frame)) {
    if (frame == "base_link") return frame;
    if (kWorldFrames.count(frame) > 0) break;
    base = frame;
  }
  return base;
}

}  // namespace

/// A scan as recorded, with what tf needs to know of it.
struct BagRecording::Message {
  LaserScan scan;
  std::string frame;
  ros::Time time;
};

struct BagRecording::State {
  rosbag::Bag bag;
  BagTopics topics;
  std::string scan_topic;
  std::unique_ptr<BagTransforms> transforms;
  std::unique_ptr<BagOdometry> odometry;  ///< null: from tf, or none
  std::string laser_frame;                ///< of the first scan
  std::string base_frame;
  std::string odom_frame;  ///< in tf; "" where odometry is not from tf
  std::string odometry_source = "no odometry";
  std::unique_ptr<rosbag::View> view;
  rosbag::View::iterator position;
  std::set<std::string> warned;
  MonotoneTime monotone_time;

  void chooseScanTopic(const std::string& wanted);
  void findLaserFrame();
  void chooseBaseFrame(const std::string& wanted);
  void chooseOdometry(const std::string& wanted);
  std::optional<Pose2> odometryAt(const LaserScan& scan, const ros::Time& time) const;
};

void BagRecording::State::chooseScanTopic(const std::string& wanted) {
  scan_topic =
      wanted.empty() ? busiestTopic(topics, kScanType) : requireTopic(topics, wanted, kScanType);
  if (scan_topic.empty()) {
    throw std::runtime_error("has no " + kScanType +
                             " messages, so there is nothing to map; its "
                             "topics: " +
                             listTopics(topics, ""));
  }
  requireVersion<sensor_msgs::LaserScan>(topics, scan_topic);
}

void BagRecording::State::findLaserFrame() {
  for (const rosbag::MessageInstance& message : *view) {
    try {
      laser_frame = withoutSlash(deserializeScan(message).header.frame_id);
      return;
    } catch (const std::exception&) {
      continue;  // next() counts it
    }
  }
}

void BagRecording::State::chooseBaseFrame(const std::string& wanted) {
  base_frame = withoutSlash(wanted);
  if (!base_frame.empty()) return;
  base_frame =
      transforms->knows("base_link") ? "base_link" : vehicleFrameAbove(*transforms, laser_frame);
}

void BagRecording::State::chooseOdometry(const std::string& wanted) {
  for (const std::string& frame : transforms->ancestors(base_frame)) {
    if (odom_frame.empty() && frame.find("odom") != std::string::npos) odom_frame = frame;
  }
  std::string topic = wanted.empty() ? "" : requireTopic(topics, wanted, kOdometryType);
  if (topic.empty() && countOfType(topics, kOdometryType) == 1) {
    topic = busiestTopic(topics, kOdometryType);
  }
  if (!topic.empty()) {
    requireVersion<nav_msgs::Odometry>(topics, topic);
    odometry = std::make_unique<BagOdometry>(bag, topic);
    odometry_source = "odometry " + topic;
    odom_frame.clear();
  } else if (!odom_frame.empty()) {
    odometry_source = "odometry tf " + odom_frame + " -> " + base_frame;
  }
}

std::optional<Pose2> BagRecording::State::odometryAt(const LaserScan& scan,
                                                     const ros::Time& time) const {
  if (!odometry) {
    if (odom_frame.empty()) return std::nullopt;
    const auto transform = transforms->lookup(odom_frame, base_frame, time);
    return transform ? std::optional<Pose2>(toPose2(*transform)) : std::nullopt;
  }
  const std::optional<Pose2> pose = odometry->at(scan.stamp);
  const std::string& child = odometry->childFrame();
  if (!pose || child.empty() || child == base_frame) return pose;
  const auto child_T_base = transforms->lookup(child, base_frame, time);
  return child_T_base ? *pose * toPose2(*child_T_base) : *pose;
}

BagRecording::BagRecording(const std::string& path, const RecordingOptions& options)
    : state_(std::make_unique<State>()) {
  State& state = *state_;
  openBag(state.bag, path);
  try {
    state.topics = topicsOf(state.bag);
    state.chooseScanTopic(options.scan_topic);
    state.transforms = std::make_unique<BagTransforms>(state.bag);
    state.view = std::make_unique<rosbag::View>(state.bag, rosbag::TopicQuery(state.scan_topic));
    state.findLaserFrame();
    state.chooseBaseFrame(options.base_frame);
    state.chooseOdometry(options.odom_topic);
    state.position = state.view->begin();
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
  if (options.scan_topic.empty() && countOfType(state.topics, kScanType) > 1) {
    warnOnce("scan topics", "several laser topics, the busiest is used: " + state.scan_topic +
                                "; there are " + listTopics(state.topics, kScanType));
  }
  if (options.odom_topic.empty() && countOfType(state.topics, kOdometryType) > 1) {
    warnOnce("odom topics", "several odometry topics, none is used; choose one of: " +
                                listTopics(state.topics, kOdometryType));
  }
  if (!state.transforms->knows(state.laser_frame) && state.base_frame == state.laser_frame) {
    warnOnce("no tf", std::string("the bag has no tf") +
                          (state.transforms->empty() ? "" : " of frame " + state.laser_frame) +
                          ": the laser is taken to be at the vehicle's base, level");
  }
}

BagRecording::~BagRecording() = default;

bool BagRecording::next(RecordedScan& scan) {
  while (state_->position != state_->view->end()) {
    Message message;
    const bool readable = read(message);
    ++state_->position;
    if (readable && place(message, scan)) return true;
  }
  return false;
}

bool BagRecording::read(Message& message) {
  try {
    const rosbag::MessageInstance& instance = *state_->position;
    const sensor_msgs::LaserScan content = deserializeScan(instance);
    const bool stamped = !content.header.stamp.isZero();
    if (!stamped) {
      warnOnce("no stamp", "scans without a stamp get the time at which they were recorded");
    }
    message.time = stamped ? content.header.stamp : instance.getTime();
    message.frame = withoutSlash(content.header.frame_id);
    message.scan = toLaserScan(content);
    message.scan.stamp = toSeconds(message.time);
    return true;
  } catch (const std::exception& error) {
    ++skipped_["broken message"];
    warnOnce("broken message",
             "a broken message on " + state_->scan_topic + " was skipped: " + error.what());
    return false;
  }
}

bool BagRecording::place(const Message& message, RecordedScan& scan) {
  State& state = *state_;
  const auto base_T_laser = state.transforms->lookup(state.base_frame, message.frame, message.time);
  if (!base_T_laser) {
    const bool connected = state.transforms->connected(state.base_frame, message.frame);
    const std::string pair = state.base_frame + " -> " + message.frame;
    skip(connected ? "transform not recorded at this time" : "missing transform",
         connected ? "tf of " + pair + " was not recorded over the whole time of the scans"
                   : "the bag has no tf " + pair +
                         "; the laser's driver or robot_state_publisher should publish it (or "
                         "choose another base frame)");
    return false;
  }
  scan.base_T_laser = *base_T_laser;
  scan.odom_T_base = state.odometryAt(message.scan, message.time);
  if (hasOdometry() && !scan.odom_T_base) {
    warnOnce("odometry gap", "some scans have no odometry at their time");
  }
  scan.scan = message.scan;
  scan.time = state.monotone_time.repair(message.scan.stamp);
  return true;
}

void BagRecording::skip(const std::string& reason, const std::string& warning) {
  ++skipped_[reason];
  warnOnce(reason + warning, warning);
}

void BagRecording::warnOnce(const std::string& key, const std::string& warning) {
  if (state_->warned.insert(key).second) warnings_.push_back(warning);
}

std::size_t BagRecording::scanCount() const { return state_->view->size(); }

bool BagRecording::hasOdometry() const {
  return !state_->odom_frame.empty() || (state_->odometry && !state_->odometry->empty());
}

std::string BagRecording::description() const {
  return "rosbag, " + std::to_string(scanCount()) + " scans on " + state_->scan_topic + ", laser " +
         state_->laser_frame + " on " + state_->base_frame + ", " + state_->odometry_source;
}

}  // namespace kestrel_slam
