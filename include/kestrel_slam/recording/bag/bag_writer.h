// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "kestrel_slam/recording/recording.h"

namespace kestrel {

/// Which time becomes the header stamp of a converted scan.
enum class BagStamps {
  kRecorded,  ///< the stamp as recorded, which names the scan, even where stamps jump back
  kMonotone   ///< the repaired time
};

/// What was written, and what could not be.
struct BagSummary {
  std::size_t scans = 0;
  std::size_t unwritable = 0;  ///< scans whose stamp ROS cannot express (negative, after 2106)
};

/// Writes a recording as a rosbag: /scan (frame laser), /odom and /tf (odom -> base_link) where it
/// has odometry, and a latched /tf_static (base_link -> laser).
///
/// Messages are recorded at the repaired time, so that a replay's clock never goes back. Scan,
/// odometry and tf of one instant have the same stamp, and tf comes before its scan: a tf lookup at
/// the stamp of the scan gives the very odometry of its line, even where the stamp is late.
/// The bag appears under its name only when complete. Throws std::runtime_error.
BagSummary writeBag(const std::string& path, Recording& recording, BagStamps stamps);

}  // namespace kestrel
