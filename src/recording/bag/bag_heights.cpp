// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/recording/bag/bag_imu.h"
#include "kestrel_slam/recording/bag/bag_odometry.h"

namespace kestrel {
namespace {

const std::string kRangeType = "sensor_msgs/Range";

/// The beam of a sensor_msgs/Range runs along the x axis of its frame.
bool looksDown(const Eigen::Isometry3d& base_T_sensor) {
  constexpr double kMinCosine = 0.94;  // within 20 degrees of vertical
  return base_T_sensor.linear()(2, 0) < -kMinCosine;
}

long degreesFromDown(const Eigen::Isometry3d& base_T_sensor) {
  const double cosine = std::clamp(-base_T_sensor.linear()(2, 0), -1.0, 1.0);
  return std::lround(radToDeg(std::acos(cosine)));
}

std::string withoutMounting(const std::string& topic) {
  return "tf has no mounting of the range finder " + topic +
         ": it is assumed to be at the base and to look down";
}

/// The mounting of the sensor of a topic, from the first message for which tf has a transform.
std::optional<Eigen::Isometry3d> mountingOf(const BagFiles& files, const BagTransforms& transforms,
                                            const std::string& base_frame,
                                            const std::string& topic) {
  BagMessages messages(files, {topic});
  while (const rosbag::MessageInstance* instance = messages.next()) {
    try {
      const auto message = instance->instantiate<sensor_msgs::Range>();
      if (!message) continue;
      const std::string frame = withoutSlash(message->header.frame_id);
      if (!transforms.connected(base_frame, frame)) return std::nullopt;
      const auto base_T_sensor = transforms.lookup(base_frame, frame, message->header.stamp);
      if (base_T_sensor) return base_T_sensor;
    } catch (const std::exception&) {
      messages.noteFailure();  // counted when the topic is read
    }
  }
  return std::nullopt;
}

/// Selects the Range topic that measures the height.
class RangeFinderChoice {
 public:
  RangeFinderChoice(const BagFiles& files, const BagTopics& topics, const BagTransforms& transforms,
                    std::string base_frame)
      : files_(files),
        topics_(topics),
        transforms_(transforms),
        base_frame_(std::move(base_frame)) {}

  /// The topic; "" if none can be used.
  std::string choose(const std::string& wanted, BagHeights& result);
  double sensorZ() const { return base_T_sensor_ ? base_T_sensor_->translation().z() : 0.0; }

 private:
  std::string chooseWanted(const std::string& wanted, BagHeights& result);

  const BagFiles& files_;
  const BagTopics& topics_;
  const BagTransforms& transforms_;
  std::string base_frame_;
  std::optional<Eigen::Isometry3d> base_T_sensor_;
};

/// A topic that the user names is used in any case, but not without a word.
std::string RangeFinderChoice::chooseWanted(const std::string& wanted, BagHeights& result) {
  const std::string topic = requireTopic(topics_, wanted, kRangeType);
  requireVersion<sensor_msgs::Range>(topics_, topic);
  base_T_sensor_ = mountingOf(files_, transforms_, base_frame_, topic);
  if (!base_T_sensor_) {
    result.warnings.push_back(withoutMounting(topic));
  } else if (!looksDown(*base_T_sensor_)) {
    result.warnings.push_back("according to tf, the range finder " + topic + " looks " +
                              std::to_string(degreesFromDown(*base_T_sensor_)) +
                              " degrees away from down; it is used as --height-topic says");
  }
  return topic;
}

std::string RangeFinderChoice::choose(const std::string& wanted, BagHeights& result) {
  if (!wanted.empty()) return chooseWanted(wanted, result);
  std::string without_tf;
  for (const auto& [topic, info] : topics_) {
    if (info.type != kRangeType || info.messages == 0) continue;
    const auto base_T_sensor = mountingOf(files_, transforms_, base_frame_, topic);
    if (!base_T_sensor) {
      without_tf = topic;
    } else if (looksDown(*base_T_sensor)) {
      base_T_sensor_ = base_T_sensor;
      return topic;
    }
  }
  const std::size_t count = countOfType(topics_, kRangeType);
  if (count == 1 && !without_tf.empty()) {
    result.warnings.push_back(withoutMounting(without_tf));
    return without_tf;
  }
  if (count > 0) {
    result.warnings.push_back(
        "according to tf, no range finder looks down, so the height is not used; choose one of: " +
        listTopics(topics_, kRangeType));
  }
  return "";
}

}  // namespace

BagHeights readBagHeights(const BagFiles& files, const BagTopics& topics,
                          const BagTransforms& transforms, const std::string& base_frame,
                          const std::string& wanted) {
  BagHeights result;
  RangeFinderChoice choice(files, topics, transforms, base_frame);
  result.topic = choice.choose(wanted, result);
  if (result.topic.empty()) return result;
  result.broken = files.forEach(result.topic, [&](const rosbag::MessageInstance& instance) {
    const auto message = instance.instantiate<sensor_msgs::Range>();
    if (!message) throw std::runtime_error("another type on the same topic");
    if (message->header.stamp.isZero()) message->header.stamp = instance.getTime();
    result.samples.push_back(toHeightSample(*message, choice.sensorZ()));
  });
  return result;
}

}  // namespace kestrel
