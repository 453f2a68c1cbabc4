// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace kestrel {

/// The format of a file, by its content: "rosbag", "CARMEN log", "BreezySLAM log", "table of
/// ranges", or "" for anything else. Throws std::runtime_error if it cannot be read.
std::string recordingFormat(const std::string& path);

/// What a file is, found without reading its scans.
struct RecordingInfo {
  struct Topic {
    std::string type;
    std::size_t messages = 0;
  };

  std::string format;                   ///< see recordingFormat(); "" if it is no recording
  std::string problem;                  ///< why it cannot be read; "" if it can
  double begin = 0.0, end = 0.0;        ///< bags: record times of the first and last message, s
  std::map<std::string, Topic> topics;  ///< bags
};

/// Never throws: what is wrong with the file is in `problem`. `quick`: of a bag only the index at
/// its end is read, so that damage before it is not found.
RecordingInfo infoOf(const std::string& path, bool quick = false);

}  // namespace kestrel
