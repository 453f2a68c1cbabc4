#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/tools/simulator.h"

namespace kestrel_slam {

/// Writes a simulated flight as a rosbag: `/scan`, `/tf_static` (base_link to laser) and
/// `/ground_truth` (nav_msgs/Odometry of base_link in the frame `world`). The file appears under
/// its name only when it is complete. Throws std::runtime_error that names the file and the reason.
void writeFlightBag(const std::string& path, const std::vector<SimulatedScan>& flight,
                    const Pose2& base_T_laser);

}  // namespace kestrel_slam
