// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "kestrel_slam/recording/recording.h"

namespace kestrel {

/// Reads a rosbag in the order of recording: scans (LaserScan, or PointCloud2 of a 3D lidar), the
/// sensor mounting from tf, odometry from an Odometry topic or tf, the IMU and the range finder.
///
/// If the bag has no tf, the laser frame is used as the base frame. A header stamp of 0 is replaced
/// by the time at which the message was recorded.
class BagRecording : public Recording {
 public:
  /// Throws std::runtime_error if the bag cannot be read or has no laser.
  BagRecording(const std::string& path, const RecordingOptions& options);
  ~BagRecording() override;

  bool next(RecordedScan& scan) override;
  std::size_t scanCount() const override;
  std::string description() const override;
  bool hasOdometry() const override;

 private:
  struct State;
  struct Message;

  void readImu(const RecordingOptions& options);
  void readHeights(const RecordingOptions& options);
  void explainChoices(const RecordingOptions& options);
  bool read(Message& message);
  bool place(Message& message, RecordedScan& scan);
  void skip(const std::string& reason, const std::string& warning);
  void warnOnce(const std::string& key, const std::string& warning);

  std::unique_ptr<State> state_;
};

}  // namespace kestrel
