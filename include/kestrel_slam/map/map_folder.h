// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/map/map_snapshot.h"

namespace kestrel {

struct NamedContent {
  std::string name;
  std::string content;
};

/// Writes `map.pgm`, `map.yaml` and other files of one run into a folder, in one step: whenever the
/// process is killed, all files are of the old or all are of the new run. For this the files are
/// written to a new folder beside, which then takes the place of the old one. That is not possible
/// if the folder holds anything else, is the working folder, is mounted, or if the file system
/// cannot exchange folders. Then the files are replaced one by one, and only `map.yaml` and its
/// image always fit together. Throws std::runtime_error with the file and the reason.
void writeMapFolder(const std::string& folder, const MapSnapshot& map,
                    const std::vector<NamedContent>& others);

/// Throws std::runtime_error with the reason if writeMapFolder could not write into the folder.
void requireWritable(const std::string& folder);

}  // namespace kestrel
