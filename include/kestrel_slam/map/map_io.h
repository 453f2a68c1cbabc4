// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/map/map_snapshot.h"

namespace kestrel {

/// Writes `<stem>.pgm` and `<stem>.yaml` in the format of map_server: free 254, unknown 205,
/// occupied 0; mode trinary, thresholds 0.65 and 0.196; `image:` relative to the yaml file. An
/// older map of this name is replaced in one step: whenever the process is killed, the YAML file
/// and its image are the whole old or the whole new map. Throws std::runtime_error with the file
/// and the reason.
void writeMap(const std::string& stem, const MapSnapshot& map);

/// Reads a map that writeMap or map_saver has written. Throws std::runtime_error with the file and
/// the reason.
MapSnapshot readMap(const std::string& yaml_path);

}  // namespace kestrel
