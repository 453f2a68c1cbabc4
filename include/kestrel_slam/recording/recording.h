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

/// One scan of a recording with all data for the mapper.
struct RecordedScan {
  LaserScan scan;  ///< `scan.stamp` is the recorded stamp, which identifies the scan
  std::optional<PointCloud> cloud;  ///< of a 3D lidar; `scan` then has a stamp, but no beams
  double time = 0.0;                ///< the stamp, corrected to be strictly increasing, s
  Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();
  std::optional<Pose2> odom_T_base;  ///< odometry at the time of the scan, if recorded
};

/// All readings of an IMU, in the order of the file.
struct RecordedImu {
  std::vector<ImuSample> samples;
  Eigen::Isometry3d base_T_imu = Eigen::Isometry3d::Identity();
  std::string topic;
};

/// How to read a recording.
struct RecordingOptions {
  std::string scan_topic;  ///< bags: LaserScan or PointCloud2; empty: the LaserScan topic with the
                           ///< most messages, or a PointCloud2 topic if there is none
  std::string odom_topic;  ///< bags: empty: the only Odometry topic, or tf odom -> base
  std::string base_frame;  ///< bags: empty: base_link, or else the topmost non-world frame of tf
  std::string imu_topic;   ///< bags: empty: the Imu topic with the most messages
  std::string height_topic;    ///< bags: empty: the Range topic that looks down
  bool prefer_clouds = false;  ///< bags: use PointCloud2 even if there is a LaserScan topic
  double rate_hz = 40.0;       ///< tables of ranges: scan rate, if the table has no stamps
  double fov_deg = 0.0;        ///< tables of ranges: field of view, if the table has no angles; 0:
                               ///< from the number of ranges
};

/// A rosbag or log file. Scans are read one by one in the order of the file.
class Recording {
 public:
  virtual ~Recording() = default;

  /// Reads the next scan; false at the end. Messages that cannot be used (for example a broken line
  /// or a scan without transform) are skipped and counted in `skipped()`.
  virtual bool next(RecordedScan& scan) = 0;

  virtual std::size_t scanCount() const = 0;    ///< scans in the file
  virtual std::string description() const = 0;  ///< one line: format, topics, frames
  virtual bool hasOdometry() const = 0;

  /// All IMU readings; no samples if there is no IMU.
  virtual const RecordedImu& imu() const { return imu_; }
  /// Readings of the downward range finder, in the order of the file.
  virtual const std::vector<HeightSample>& heights() const { return heights_; }

  /// Number of skipped messages for each reason, for example {"broken line", 1}.
  const std::map<std::string, std::size_t>& skipped() const { return skipped_; }
  /// Warnings for the user: each problem once, with the place of its first occurrence.
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  std::map<std::string, std::size_t> skipped_;
  std::vector<std::string> warnings_;
  RecordedImu imu_;
  std::vector<HeightSample> heights_;
};

/// Opens `path`. The content determines the format: a rosbag ("#ROSBAG"), a CARMEN log, a
/// BreezySLAM log or a table of ranges (plain, .bz2, .gz or .xz). Throws std::runtime_error with
/// one line that names the file, the problem and a remedy: the file does not exist, is a folder,
/// has an unknown format, or has no laser (the message lists its topics).
std::unique_ptr<Recording> openRecording(const std::string& path,
                                         const RecordingOptions& options = RecordingOptions());

}  // namespace kestrel
