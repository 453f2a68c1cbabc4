// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "kestrel_slam/recording/recording.h"

namespace kestrel {

/// The time that becomes the header stamp of a converted scan.
enum class BagStamps {
  kRecorded,  ///< the recorded stamp, which identifies the scan; may jump back
  kMonotone   ///< the corrected, strictly increasing time
};

/// Numbers of scans that were written and that could not be written.
struct BagSummary {
  std::size_t scans = 0;
  std::size_t unwritable = 0;  ///< scans whose stamp ROS cannot represent (negative, after 2106)
};

/// Writes a recording as a rosbag: /scan (frame laser), /odom and /tf (odom -> base_link) if it has
/// odometry, and a latched /tf_static (base_link -> laser).
///
/// The record times of the messages are the corrected times, so that the clock of a replay never
/// jumps back. Scan, odometry and tf of one line of the log have the same header stamp, and tf
/// comes before the scan. A tf lookup at the stamp of the scan therefore gives the odometry of the
/// same line. The bag gets its final name only when it is complete. Throws std::runtime_error if it
/// cannot be written.
BagSummary writeBag(const std::string& path, Recording& recording, BagStamps stamps);

}  // namespace kestrel
