// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/reference.h"

#include <stdexcept>

#include "kestrel_slam/recording/file_kind.h"
#ifdef KESTREL_WITH_ROS
#include "kestrel_slam/recording/bag/bag_reference.h"
#endif

namespace kestrel {

bool isBag(const std::string& path) {
  static const std::string kMagic = "#ROSBAG";
  return startOf(path).compare(0, kMagic.size(), kMagic) == 0;
}

Trajectory readReference(const std::string& path, const std::string& topic) {
  if (!isBag(path)) {
    if (topic.empty()) return readTum(path);
    throw std::runtime_error(path + ": is not a rosbag, so it has no topic " + topic +
                             "; omit the topic or use a bag");
  }
#ifdef KESTREL_WITH_ROS
  return readBagReference(path, topic);
#else
  throw std::runtime_error(path +
                           ": this build has no ROS and cannot read a rosbag; build with "
                           "-DKESTREL_WITH_ROS=ON or use a trajectory in the TUM format");
#endif
}

}  // namespace kestrel
