// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/recording_info.h"

#include <exception>
#include <filesystem>

#include "kestrel_slam/recording/file_kind.h"
#ifdef KESTREL_WITH_ROS
#include "kestrel_slam/recording/bag/bag_files.h"
#include "kestrel_slam/recording/bag/bag_index.h"
#endif

namespace kestrel {
namespace {

#ifdef KESTREL_WITH_ROS
void addBag(const BagTopics& topics, double begin, double end, RecordingInfo& info) {
  info.begin = begin;
  info.end = end;
  for (const auto& [name, topic] : topics) info.topics[name] = {topic.type, topic.messages};
}

/// False where only a look at the whole bag can say what is wrong with it.
bool addIndex(const std::string& path, RecordingInfo& info) try {
  const BagIndex index = readBagIndex(path);
  addBag(index.topics, index.begin, index.end, info);
  return true;
} catch (const std::exception&) {
  return false;
}

void addBag(const std::string& path, bool quick, RecordingInfo& info) {
  if (quick && addIndex(path, info)) return;
  const BagFiles bag({path});
  addBag(bag.topics(), bag.begin(), bag.end(), info);
}
#else
void addBag(const std::string&, bool, RecordingInfo&) {}
#endif

}  // namespace

RecordingInfo infoOf(const std::string& path, bool quick) {
  RecordingInfo info;
  try {
    if (!std::filesystem::is_directory(path)) info.format = recordingFormat(path);
    if (info.format.empty()) info.problem = foreignKind(path);
    if (info.format == "rosbag") addBag(path, quick, info);
  } catch (const std::exception& error) {
    info.problem = error.what();
  }
  return info;
}

}  // namespace kestrel
