// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/recording/bag/bag_scan_messages.h"
#include "kestrel_slam/recording/recording.h"

namespace kestrel {

/// Reads a rosbag, or the bags of a recording that was split, in the order of recording: scans
/// (LaserScan or MultiEchoLaserScan, or PointCloud2 or PointCloud of a 3D lidar), the sensor
/// mounting from tf, odometry from an Odometry topic or tf, the IMU and the range finder.
///
/// If the bag has no tf, the laser frame is used as the base frame. A header stamp of 0 is replaced
/// by the time at which the message was recorded.
class BagRecording : public Recording {
 public:
  /// Throws std::runtime_error if the bag cannot be read or has no laser.
  BagRecording(const std::vector<std::string>& paths, const RecordingOptions& options);
  ~BagRecording() override;

  bool next(RecordedScan& scan) override;
  std::size_t scanCount() const override;
  std::string description() const override;
  bool hasOdometry() const override;

 private:
  struct State;

  void open(const RecordingOptions& options);
  void chooseFrames(const RecordingOptions& options);
  void readImu(const RecordingOptions& options);
  void readHeights(const RecordingOptions& options);
  void explainFrames();
  void compareClocks(const std::string& what, double clock_offset);
  bool place(BagScan& message, RecordedScan& scan);
  void skipUnplaced(const BagScan& message);
  void skip(const std::string& reason, const std::string& warning, std::size_t count = 1);
  void warn(const std::vector<std::string>& warnings);
  void warnOnce(const std::string& key, const std::string& warning);

  std::unique_ptr<State> state_;
};

}  // namespace kestrel
