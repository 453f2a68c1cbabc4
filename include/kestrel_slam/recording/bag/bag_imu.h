// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/Imu.h>
#include <sensor_msgs/Range.h>

#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/recording/bag/bag_files.h"
#include "kestrel_slam/recording/bag/bag_topics.h"
#include "kestrel_slam/recording/bag/bag_transforms.h"
#include "kestrel_slam/recording/recording.h"

namespace kestrel {

/// The IMU data of a bag, and warnings for the user.
struct BagImu {
  RecordedImu imu;
  std::size_t broken = 0;  ///< messages that could not be read
  std::vector<std::string> warnings;
  double clock_offset = 0.0;  ///< stamp minus time of recording of the first reading, s
};
/// The range finder data of a bag, and warnings for the user.
struct BagHeights {
  std::vector<HeightSample> samples;
  std::string topic;
  std::size_t broken = 0;
  std::vector<std::string> warnings;
};

/// Reads the IMU topic `wanted` and its mounting from tf. If `wanted` is "", reads the most
/// complete IMU topic; of equally complete ones the one with the most messages. If a gyro and an
/// accelerometer have a topic each, their readings are joined (see ImuJoiner). Throws
/// std::runtime_error if the bag has no topic `wanted`.
BagImu readBagImu(const BagFiles& files, const BagTopics& topics, const BagTransforms& transforms,
                  const std::string& base_frame, const std::string& wanted);

/// Reads the Range topic `wanted`. If it is "", reads a topic whose sensor looks down according to
/// tf, or the only Range topic if tf does not know its frame. Throws std::runtime_error if the bag
/// has no topic `wanted`.
BagHeights readBagHeights(const BagFiles& files, const BagTopics& topics,
                          const BagTransforms& transforms, const std::string& base_frame,
                          const std::string& wanted);

}  // namespace kestrel
