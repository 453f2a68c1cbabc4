// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/recording.h"

#include <filesystem>
#include <stdexcept>

#include "kestrel_slam/recording/breezy_log.h"
#include "kestrel_slam/recording/carmen_log.h"
#include "kestrel_slam/recording/file_kind.h"
#include "kestrel_slam/recording/range_table.h"
#include "kestrel_slam/recording/recording_info.h"
#include "kestrel_slam/recording/reference.h"
#ifdef KESTREL_WITH_ROS
#include "kestrel_slam/recording/bag/bag_recording.h"
#endif

namespace kestrel {
namespace {

const std::string kBag = "rosbag", kCarmenLog = "CARMEN log", kBreezyLog = "BreezySLAM log",
                  kRangeTable = "table of ranges";

std::unique_ptr<Recording> openBags(const std::vector<std::string>& paths,
                                    [[maybe_unused]] const RecordingOptions& options) {
#ifdef KESTREL_WITH_ROS
  return std::make_unique<BagRecording>(paths, options);
#else
  throw std::runtime_error(paths.front() +
                           ": this build has no ROS and cannot read a rosbag; build with "
                           "-DKESTREL_WITH_ROS=ON or use a CARMEN log");
#endif
}

void requireContent(const std::string& path) {
  if (std::filesystem::is_regular_file(path) && std::filesystem::file_size(path) == 0) {
    throw std::runtime_error(path + ": the file is empty (0 bytes); record or copy it again");
  }
  if (std::filesystem::exists(path) && !std::filesystem::is_regular_file(path) &&
      !std::filesystem::is_directory(path)) {
    throw std::runtime_error(path +
                             ": is a pipe or a device, not a file; save the recording first");
  }
  const std::string kind = foreignKind(path);
  if (!kind.empty()) throw std::runtime_error(path + ": " + kind);
}

}  // namespace

std::string recordingFormat(const std::string& path) {
  if (isBag(path)) return kBag;
  if (looksLikeCarmenLog(path)) return kCarmenLog;
  if (looksLikeBreezyLog(path)) return kBreezyLog;
  if (looksLikeRangeTable(path)) return kRangeTable;
  return "";
}

std::unique_ptr<Recording> openRecording(const std::string& path, const RecordingOptions& options) {
  requireContent(path);
  const std::string format = recordingFormat(path);
  if (format == kBag) return openBags({path}, options);
  if (format == kCarmenLog) return std::make_unique<CarmenLog>(path);
  if (format == kBreezyLog) return std::make_unique<BreezyLog>(path);
  if (format == kRangeTable) return std::make_unique<RangeTable>(path, options);
  throw std::runtime_error(
      path +
      ": unknown format; use a rosbag, a CARMEN log, a BreezySLAM log or a table of "
      "ranges (plain, .bz2, .gz or .xz)");
}

std::unique_ptr<Recording> openRecording(const std::vector<std::string>& paths,
                                         const RecordingOptions& options) {
  if (paths.size() == 1) return openRecording(paths.front(), options);
  for (const std::string& path : paths) {
    requireContent(path);
    if (isBag(path)) continue;
    throw std::runtime_error(path + ": is no rosbag; only bags can be parts of one recording");
  }
  return openBags(paths, options);
}

}  // namespace kestrel
