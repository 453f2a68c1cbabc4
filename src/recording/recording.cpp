// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/recording.h"

#include <filesystem>
#include <stdexcept>

#include "kestrel_slam/recording/breezy_log.h"
#include "kestrel_slam/recording/carmen_log.h"
#include "kestrel_slam/recording/range_table.h"
#include "kestrel_slam/recording/reference.h"
#ifdef KESTREL_WITH_ROS
#include "kestrel_slam/recording/bag/bag_recording.h"
#endif

namespace kestrel {
namespace {

std::unique_ptr<Recording> openBag(const std::string& path,
                                   [[maybe_unused]] const RecordingOptions& options) {
#ifdef KESTREL_WITH_ROS
  return std::make_unique<BagRecording>(path, options);
#else
  throw std::runtime_error(path +
                           ": this build has no ROS and cannot read a rosbag; build with "
                           "-DKESTREL_WITH_ROS=ON or use a CARMEN log");
#endif
}

}  // namespace

std::unique_ptr<Recording> openRecording(const std::string& path, const RecordingOptions& options) {
  if (std::filesystem::is_regular_file(path) && std::filesystem::file_size(path) == 0) {
    throw std::runtime_error(path + ": the file is empty (0 bytes); record or copy it again");
  }
  if (isBag(path)) return openBag(path, options);
  if (looksLikeCarmenLog(path)) return std::make_unique<CarmenLog>(path);
  if (looksLikeBreezyLog(path)) return std::make_unique<BreezyLog>(path);
  if (looksLikeRangeTable(path)) return std::make_unique<RangeTable>(path, options);
  throw std::runtime_error(
      path +
      ": unknown format; use a rosbag, a CARMEN log, a BreezySLAM log or a table of "
      "ranges (plain, .bz2, .gz or .xz)");
}

}  // namespace kestrel
