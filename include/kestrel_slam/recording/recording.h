// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/sensor/imu_sample.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// One scan of a recording with everything the mapper may use of it.
struct RecordedScan {
  LaserScan scan;                   ///< `scan.stamp` is the stamp as recorded, the scan's name
  std::optional<PointCloud> cloud;  ///< of a 3D lidar; `scan` has then no beams, only the stamp
  double time = 0.0;  ///< the same instant on a repaired, strictly monotone time base, s
  Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();
  std::optional<Pose2> odom_T_base;  ///< odometry at the scan's time, where the recording has it
};

/// What an IMU recorded, in the order of the file.
struct RecordedImu {
  std::vector<ImuSample> samples;
  Eigen::Isometry3d base_T_imu = Eigen::Isometry3d::Identity();
  std::string topic;
};

/// How to read a recording.
struct RecordingOptions {
  std::string scan_topic;    ///< bags: LaserScan or PointCloud2; empty means the only (or the
                             ///< busiest) LaserScan topic, or PointCloud2 topic where there is none
  std::string odom_topic;    ///< bags: empty means the only Odometry topic, or tf odom -> base
  std::string base_frame;    ///< bags: empty means base_link, or what tf says lies above the laser
  std::string imu_topic;     ///< bags: empty means the only (or the busiest) Imu topic
  std::string height_topic;  ///< bags: empty means the only Range topic
  bool prefer_clouds = false;  ///< bags: PointCloud2 topics before LaserScan topics
  double rate_hz = 40.0;       ///< scans a second of a table of ranges, which has no stamps
};

/// A rosbag or log, read scan by scan in the order of the file.
class Recording {
 public:
  virtual ~Recording() = default;

  /// Reads the next scan; false at the end. Messages that cannot be used (a broken line, a scan
  /// whose transform is missing) are skipped and counted in `skipped()`, never lost silently.
  virtual bool next(RecordedScan& scan) = 0;

  virtual std::size_t scanCount() const = 0;    ///< scans in the file
  virtual std::string description() const = 0;  ///< one line: format, topics, frames
  virtual bool hasOdometry() const = 0;

  /// The whole record of the IMU; no samples where there is none.
  virtual const RecordedImu& imu() const { return imu_; }
  /// Readings of a range finder that looks down, in the order of the file.
  virtual const std::vector<HeightSample>& heights() const { return heights_; }

  /// Skipped messages by reason, for example {"broken line", 1}.
  const std::map<std::string, std::size_t>& skipped() const { return skipped_; }
  /// Sentences for the user: each problem once, with the first place where it occurred.
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  std::map<std::string, std::size_t> skipped_;
  std::vector<std::string> warnings_;
  RecordedImu imu_;
  std::vector<HeightSample> heights_;
};

/// Opens `path` by its content: a rosbag ("#ROSBAG"), or a CARMEN log, a BreezySLAM log or a table
/// of ranges, plain, .bz2, .gz or .xz. Throws std::runtime_error with one line that says what is
/// wrong with which file and what to do: it does not exist, is a folder, is none of these, has no
/// laser (lists the topics it has).
std::unique_ptr<Recording> openRecording(const std::string& path,
                                         const RecordingOptions& options = RecordingOptions());

}  // namespace kestrel
