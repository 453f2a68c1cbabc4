// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/Imu.h>

#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/recording/bag/bag_files.h"
#include "kestrel_slam/recording/bag/bag_transforms.h"
#include "kestrel_slam/sensor/imu_sample.h"

namespace kestrel {

/// All readings on one topic of sensor_msgs/Imu, and what they contain.
class ImuTopic {
 public:
  ImuTopic(const BagFiles& files, std::string name, const BagTransforms& transforms,
           const std::string& base_frame);

  const std::string& name() const { return name_; }
  const std::string& frame() const { return frame_; }
  const std::vector<ImuSample>& samples() const { return samples_; }
  std::size_t broken() const { return broken_; }
  /// base_T_imu, at the first message for which tf has it.
  const std::optional<Eigen::Isometry3d>& mounting() const { return base_T_imu_; }
  double clockOffset() const { return clock_offset_; }

  bool hasReadings() const { return !samples_.empty(); }
  /// A value exists if a message does not mark it as missing, and if it is not always 0: some
  /// drivers send 0 for what they do not measure.
  bool hasGyro() const { return gyro_.exists(); }
  bool hasAccelerometer() const { return accelerometer_.exists(); }
  /// True if the readings give an attitude.
  bool isComplete() const { return orientation_.exists() || (hasGyro() && hasAccelerometer()); }
  /// What is missing, as part of a sentence; "" if the topic is complete.
  std::string missing() const;

 private:
  struct Value {
    bool marked = false;  ///< some message marks it as missing
    bool given = false;   ///< some message does not
    bool filled = false;  ///< some message has a number other than 0, marked or not

    bool exists() const { return given && filled; }
  };

  void add(sensor_msgs::Imu& message, const rosbag::MessageInstance& instance,
           const BagTransforms& transforms, const std::string& base_frame);

  std::string name_, frame_;
  std::vector<ImuSample> samples_;
  std::size_t broken_ = 0;
  std::optional<Eigen::Isometry3d> base_T_imu_;
  double clock_offset_ = 0.0;
  Value orientation_, gyro_, accelerometer_;
};

}  // namespace kestrel
