// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_recording.h"

#include <cmath>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/recording/bag/bag_files.h"
#include "kestrel_slam/recording/bag/bag_imu.h"
#include "kestrel_slam/recording/bag/bag_odometry.h"
#include "kestrel_slam/recording/bag/bag_scans.h"
#include "kestrel_slam/recording/bag/bag_transforms.h"
#include "kestrel_slam/sensor/time_base.h"

namespace kestrel {
namespace {

/// Stamps that differ more come from different clocks, s.
constexpr double kOtherClock = 3600.0;

std::string rounded(double value) { return std::to_string(std::llround(value)); }

}  // namespace

struct BagRecording::State {
  State(const std::vector<std::string>& paths, const RecordingOptions& options)
      : files(paths, options.stop) {}

  BagFiles files;
  BagTopics topics;
  ScanTopic topic;
  std::unique_ptr<BagTransforms> transforms;
  std::unique_ptr<BagOdometrySource> odometry;
  std::optional<Eigen::Isometry3d> base_T_laser;  ///< if the user gave it
  std::string base_frame;
  std::string height_topic;
  std::unique_ptr<BagScans> scans;
  std::set<std::string> warned;
  TimeBase time_base;
};

BagRecording::BagRecording(const std::vector<std::string>& paths, const RecordingOptions& options)
    : state_(std::make_unique<State>(paths, options)) {
  try {
    open(options);
  } catch (const std::exception& error) {
    throw std::runtime_error(paths.front() + ": " + error.what());
  }
}

BagRecording::~BagRecording() = default;

void BagRecording::open(const RecordingOptions& options) {
  State& state = *state_;
  state.topics = state.files.topics();
  state.base_T_laser = options.base_T_laser;
  state.transforms = std::make_unique<BagTransforms>(state.files);
  std::vector<std::string> warnings = state.files.gapWarnings();
  state.topic = chooseScanTopic(state.files, state.topics, *state.transforms, options, warnings);
  chooseFrames(options);
  state.odometry = std::make_unique<BagOdometrySource>(state.files, state.topics, *state.transforms,
                                                       state.base_frame, options.odom_topic);
  warn(warnings);
  warn(state.odometry->warnings());
  explainFrames();
  readImu(options);
  readHeights(options);
  state.scans = std::make_unique<BagScans>(state.files, state.topic.name);
  state.scans->on_skip = [this](const std::string& reason, const std::string& warning,
                                std::size_t count) { skip(reason, warning, count); };
  state.files.finishOpening();
}

void BagRecording::chooseFrames(const RecordingOptions& options) {
  State& state = *state_;
  const BagTransforms& transforms = *state.transforms;
  if (options.base_frame.empty()) {
    state.base_frame = transforms.vehicleFrame(state.topic.frame);
    return;
  }
  state.base_frame = withoutSlash(options.base_frame);
  const bool known = transforms.knows(state.base_frame) || state.base_frame == state.topic.frame;
  if (known || state.base_T_laser) return;
  throw std::runtime_error("tf has no frame " + state.base_frame +
                           " (--base-frame); its frames: " + transforms.listFrames());
}

void BagRecording::explainFrames() {
  const State& state = *state_;
  const BagTransforms& transforms = *state.transforms;
  const bool no_tf = !transforms.knows(state.topic.frame) && state.base_frame == state.topic.frame;
  if (no_tf && !state.base_T_laser) {
    warn({std::string("the bag has no tf") +
          (transforms.empty() ? "" : " of frame " + state.topic.frame) +
          ": the laser frame is used as the base frame"});
  }
  const std::string localization = transforms.localizationOf(state.base_frame);
  if (localization.empty()) return;
  warn({"the bag has tf " + localization +
        " of another localization. It is not used here; in a replay to a node it would fight with "
        "the mapper's: use replay.launch, which leaves it out"});
}

void BagRecording::readImu(const RecordingOptions& options) {
  BagImu read = readBagImu(state_->files, state_->topics, *state_->transforms, state_->base_frame,
                           options.imu_topic);
  if (read.broken > 0) skipped_["broken IMU message"] += read.broken;
  warn(read.warnings);
  imu_ = std::move(read.imu);
  if (!imu_.samples.empty()) compareClocks("IMU", read.clock_offset);
}

/// Sensors whose stamps run hours apart cannot be combined.
void BagRecording::compareClocks(const std::string& what, double clock_offset) {
  const double difference = state_->topic.clock_offset - clock_offset;
  if (std::abs(difference) < kOtherClock) return;
  warn({"the stamps of laser and " + what + " come from different clocks: they differ by " +
        rounded(std::abs(difference)) + " s; correct the driver whose clock is wrong"});
}

void BagRecording::readHeights(const RecordingOptions& options) {
  BagHeights read = readBagHeights(state_->files, state_->topics, *state_->transforms,
                                   state_->base_frame, options.height_topic);
  if (read.broken > 0) skipped_["broken Range message"] += read.broken;
  warn(read.warnings);
  heights_ = std::move(read.samples);
  state_->height_topic = read.topic;
}

bool BagRecording::next(RecordedScan& scan) {
  BagScan message;
  while (state_->scans->next(message)) {
    if (place(message, scan)) return true;
  }
  warn(state_->files.damageWarnings());
  return false;
}

bool BagRecording::place(BagScan& message, RecordedScan& scan) {
  State& state = *state_;
  if (!message.stamped) warn({"scans have no stamp; the time of recording is used"});
  if (message.cloud && !message.cloud->time_problem.empty()) warn({message.cloud->time_problem});
  const auto base_T_laser =
      state.base_T_laser ? state.base_T_laser
                         : state.transforms->lookup(state.base_frame, message.frame, message.time);
  if (!base_T_laser) {
    skipUnplaced(message);
    return false;
  }
  scan.base_T_laser = *base_T_laser;
  scan.odom_T_base = state.odometry->at(message.scan.stamp, message.time);
  if (hasOdometry() && !scan.odom_T_base) {
    warn({"there is no odometry at the times of some scans"});
  }
  scan.time = state.time_base.repair(message.frame, message.scan.stamp);
  scan.scan = std::move(message.scan);
  scan.cloud = std::move(message.cloud);
  return true;
}

void BagRecording::skipUnplaced(const BagScan& message) {
  const State& state = *state_;
  const std::string pair = state.base_frame + " -> " + message.frame;
  if (!state.transforms->connected(state.base_frame, message.frame)) {
    skip("missing transform", "the bag has no tf " + pair +
                                  "; give the mounting with --laser-pose x,y,yaw, or choose "
                                  "another --base-frame (normally the laser driver or "
                                  "robot_state_publisher sends it)");
    return;
  }
  std::string warning = "tf " + pair + " is not available at the times of some scans";
  const double difference =
      message.scan.stamp - state.transforms->firstStamp().value_or(message.scan.stamp);
  if (std::abs(difference) > kOtherClock) {
    warning += ": the stamps of laser and tf come from different clocks, they differ by " +
               rounded(std::abs(difference)) + " s";
  }
  skip("transform not recorded at this time", warning);
}

void BagRecording::skip(const std::string& reason, const std::string& warning, std::size_t count) {
  skipped_[reason] += count;
  if (warning.empty()) return;
  skip_warnings_.emplace(reason, warning);
  warn({warning});
}

void BagRecording::warn(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) {
    if (state_->warned.insert(warning).second) warnings_.push_back(warning);
  }
}

std::size_t BagRecording::scanCount() const {
  return static_cast<std::size_t>(std::llround(static_cast<double>(state_->scans->messages()) /
                                               state_->topic.messages_per_scan));
}

bool BagRecording::hasOdometry() const { return state_->odometry->available(); }

std::string BagRecording::description() const {
  const State& state = *state_;
  std::ostringstream text;
  text << "rosbag, " << scanCount() << (state.topic.clouds ? " clouds on " : " scans on ")
       << state.topic.name;
  if (state.topic.messages_per_scan > 1.0) {
    text << " (each joined from " << state.topic.messages_per_scan << " messages)";
  }
  text << ", laser " << state.topic.frame << " on " << state.base_frame << ", "
       << state.odometry->description();
  if (!imu_.samples.empty()) text << ", IMU " << imu_.topic;
  if (!heights_.empty()) text << ", height " << state.height_topic;
  return text.str();
}

}  // namespace kestrel
