// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/recording_info.h"

#include <exception>
#include <filesystem>

#include "kestrel_slam/recording/file_kind.h"
#ifdef KESTREL_WITH_ROS
#include "kestrel_slam/recording/bag/bag_files.h"
#endif

namespace kestrel {
namespace {

#ifdef KESTREL_WITH_ROS
void addBag(const std::string& path, RecordingInfo& info) {
  const BagFiles bag({path});
  info.begin = bag.begin();
  info.end = bag.end();
  for (const auto& [name, topic] : bag.topics()) {
    info.topics[name] = {topic.type, topic.messages};
  }
}
#else
void addBag(const std::string&, RecordingInfo&) {}
#endif

}  // namespace

RecordingInfo infoOf(const std::string& path) {
  RecordingInfo info;
  try {
    if (!std::filesystem::is_directory(path)) info.format = recordingFormat(path);
    if (info.format.empty()) info.problem = foreignKind(path);
    if (info.format == "rosbag") addBag(path, info);
  } catch (const std::exception& error) {
    info.problem = error.what();
  }
  return info;
}

}  // namespace kestrel
