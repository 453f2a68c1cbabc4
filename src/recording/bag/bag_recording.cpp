// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_recording.h"

#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include <optional>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/recording/bag/bag_cloud.h"
#include "kestrel_slam/recording/bag/bag_imu.h"
#include "kestrel_slam/recording/bag/bag_odometry.h"
#include "kestrel_slam/recording/bag/bag_scan.h"
#include "kestrel_slam/recording/bag/bag_topics.h"
#include "kestrel_slam/recording/bag/bag_transforms.h"
#include "kestrel_slam/sensor/time_base.h"

namespace kestrel {
namespace {

const std::string kScanType = "sensor_msgs/LaserScan";
const std::string kCloudType = "sensor_msgs/PointCloud2";

}  // namespace

/// A recorded scan with its frame and time for tf lookups.
struct BagRecording::Message {
  LaserScan scan;
  std::optional<PointCloud> cloud;
  std::string frame;
  ros::Time time;
};

struct BagRecording::State {
  rosbag::Bag bag;
  BagTopics topics;
  std::string scan_topic;
  bool clouds = false;  ///< the scan topic is a PointCloud2 topic
  std::unique_ptr<BagTransforms> transforms;
  std::unique_ptr<BagOdometrySource> odometry;
  std::string laser_frame;  ///< of the first scan
  std::string base_frame;
  std::string height_topic;
  std::unique_ptr<rosbag::View> view;
  rosbag::View::iterator position;
  std::set<std::string> warned;
  TimeBase time_base;

  void chooseScanTopic(const RecordingOptions& options);
  void findLaserFrame();
  std_msgs::Header decode(const rosbag::MessageInstance& instance, Message& message) const;
};

void BagRecording::State::chooseScanTopic(const RecordingOptions& options) {
  const std::string& wanted = options.scan_topic;
  std::vector<std::string> types = {kScanType, kCloudType};
  if (options.prefer_clouds) std::swap(types[0], types[1]);
  if (!wanted.empty()) {
    scan_topic = requireTopic(topics, wanted, types);
  } else {
    scan_topic = busiestTopic(topics, types[0]);
    if (scan_topic.empty()) scan_topic = busiestTopic(topics, types[1]);
  }
  if (scan_topic.empty()) {
    throw std::runtime_error(
        "has no " + kScanType + " and no " + kCloudType +
        " messages, so there is nothing to map; its topics: " + listTopics(topics, ""));
  }
  clouds = topics.at(scan_topic).type == kCloudType;
  if (clouds) {
    requireVersion<sensor_msgs::PointCloud2>(topics, scan_topic);
  } else {
    requireVersion<sensor_msgs::LaserScan>(topics, scan_topic);
  }
}

/// Decodes a message. The stamp is handled by the caller, because it may be 0.
std_msgs::Header BagRecording::State::decode(const rosbag::MessageInstance& instance,
                                             Message& message) const {
  if (clouds) {
    const sensor_msgs::PointCloud2 content = deserializeCloud(instance);
    message.cloud = toPointCloud(content);
    return content.header;
  }
  const sensor_msgs::LaserScan content = deserializeScan(instance);
  message.scan = fromMessage(content);
  return content.header;
}

void BagRecording::State::findLaserFrame() {
  for (const rosbag::MessageInstance& instance : *view) {
    try {
      Message message;
      laser_frame = withoutSlash(decode(instance, message).frame_id);
      return;
    } catch (const std::exception&) {
      continue;  // counted in next()
    }
  }
}

BagRecording::BagRecording(const std::string& path, const RecordingOptions& options)
    : state_(std::make_unique<State>()) {
  State& state = *state_;
  openBag(state.bag, path);
  try {
    state.topics = topicsOf(state.bag);
    state.chooseScanTopic(options);
    state.transforms = std::make_unique<BagTransforms>(state.bag);
    state.view = std::make_unique<rosbag::View>(state.bag, rosbag::TopicQuery(state.scan_topic));
    state.findLaserFrame();
    state.base_frame = options.base_frame.empty()
                           ? state.transforms->vehicleFrame(state.laser_frame)
                           : withoutSlash(options.base_frame);
    state.odometry = std::make_unique<BagOdometrySource>(state.bag, state.topics, *state.transforms,
                                                         state.base_frame, options.odom_topic);
    explainChoices(options);
    readImu(options);
    readHeights(options);
    state.position = state.view->begin();
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

void BagRecording::explainChoices(const RecordingOptions& options) {
  const State& state = *state_;
  const std::string& type = state.clouds ? kCloudType : kScanType;
  if (options.scan_topic.empty() && countOfType(state.topics, type) > 1) {
    warnOnce("scan topics", std::string("there are several ") + (state.clouds ? "cloud" : "laser") +
                                " topics; the one with the most messages is used: " +
                                state.scan_topic + "; topics: " + listTopics(state.topics, type));
  }
  for (const std::string& warning : state.odometry->warnings()) warnOnce(warning, warning);
  if (!state.transforms->knows(state.laser_frame) && state.base_frame == state.laser_frame) {
    warnOnce("no tf", std::string("the bag has no tf") +
                          (state.transforms->empty() ? "" : " of frame " + state.laser_frame) +
                          ": the laser frame is used as the base frame");
  }
}

void BagRecording::readImu(const RecordingOptions& options) {
  BagImu read = readBagImu(state_->bag, state_->topics, *state_->transforms, state_->base_frame,
                           options.imu_topic);
  if (read.broken > 0) skipped_["broken IMU message"] += read.broken;
  for (const std::string& warning : read.warnings) warnOnce(warning, warning);
  imu_ = std::move(read.imu);
}

void BagRecording::readHeights(const RecordingOptions& options) {
  BagHeights read = readBagHeights(state_->bag, state_->topics, *state_->transforms,
                                   state_->base_frame, options.height_topic);
  if (read.broken > 0) skipped_["broken Range message"] += read.broken;
  for (const std::string& warning : read.warnings) warnOnce(warning, warning);
  heights_ = std::move(read.samples);
  state_->height_topic = read.topic;
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
    const std_msgs::Header header = state_->decode(instance, message);
    const bool stamped = !header.stamp.isZero();
    if (!stamped) {
      warnOnce("no stamp", "scans have no stamp; the time of recording is used");
    }
    message.time = stamped ? header.stamp : instance.getTime();
    message.frame = withoutSlash(header.frame_id);
    message.scan.stamp = toSeconds(message.time);
    if (message.cloud) message.cloud->stamp = message.scan.stamp;
    return true;
  } catch (const std::invalid_argument& error) {
    skip("unusable cloud",
         "a message on " + state_->scan_topic + " cannot be used: " + error.what());
  } catch (const std::exception& error) {
    ++skipped_["broken message"];
    warnOnce("broken message",
             "a message on " + state_->scan_topic + " is damaged and was skipped: " + error.what());
  }
  return false;
}

bool BagRecording::place(Message& message, RecordedScan& scan) {
  State& state = *state_;
  const auto base_T_laser = state.transforms->lookup(state.base_frame, message.frame, message.time);
  if (!base_T_laser) {
    const bool connected = state.transforms->connected(state.base_frame, message.frame);
    const std::string pair = state.base_frame + " -> " + message.frame;
    skip(connected ? "transform not recorded at this time" : "missing transform",
         connected ? "tf " + pair + " is not available at the times of some scans"
                   : "the bag has no tf " + pair +
                         "; it should be published by the laser driver or by robot_state_publisher "
                         "(or choose another base frame)");
    return false;
  }
  scan.base_T_laser = *base_T_laser;
  scan.odom_T_base = state.odometry->at(message.scan.stamp, message.time);
  if (hasOdometry() && !scan.odom_T_base) {
    warnOnce("odometry gap", "there is no odometry at the times of some scans");
  }
  scan.time = state.time_base.repair(message.frame, message.scan.stamp);
  scan.scan = std::move(message.scan);
  scan.cloud = std::move(message.cloud);
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

bool BagRecording::hasOdometry() const { return state_->odometry->available(); }

std::string BagRecording::description() const {
  const State& state = *state_;
  std::string text = "rosbag, " + std::to_string(scanCount()) +
                     (state.clouds ? " clouds on " : " scans on ") + state.scan_topic + ", laser " +
                     state.laser_frame + " on " + state.base_frame + ", " +
                     state.odometry->description();
  if (!imu_.samples.empty()) text += ", IMU " + imu_.topic;
  if (!heights_.empty()) text += ", height " + state.height_topic;
  return text;
}

}  // namespace kestrel
