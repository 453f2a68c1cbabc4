// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rosbag/bag.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/Range.h>

#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/recording/bag/bag_topics.h"
#include "kestrel_slam/recording/bag/bag_transforms.h"
#include "kestrel_slam/recording/recording.h"

namespace kestrel {

/// What a bag has of a sensor, and what the user should know of it.
struct BagImu {
  RecordedImu imu;
  std::size_t broken = 0;  ///< messages that could not be read
  std::vector<std::string> warnings;
};
struct BagHeights {
  std::vector<HeightSample> samples;
  std::string topic;
  std::size_t broken = 0;
  std::vector<std::string> warnings;
};

/// Reads the IMU topic `wanted`, or the busiest one where it is "", and the mounting from tf.
/// Throws std::runtime_error where `wanted` is not there.
BagImu readBagImu(const rosbag::Bag& bag, const BagTopics& topics, const BagTransforms& transforms,
                  const std::string& base_frame, const std::string& wanted);

/// Reads the Range topic `wanted`; where it is "", one that looks down according to tf, or the only
/// one where tf does not know its frame. Throws std::runtime_error where `wanted` is not there.
BagHeights readBagHeights(const rosbag::Bag& bag, const BagTopics& topics,
                          const BagTransforms& transforms, const std::string& base_frame,
                          const std::string& wanted);

}  // namespace kestrel
