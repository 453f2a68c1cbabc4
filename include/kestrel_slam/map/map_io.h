// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/map/map_snapshot.h"

namespace kestrel {

/// Writes `<stem>.pgm` and `<stem>.yaml` as map_server does (free 254, unknown 205, occupied 0;
/// trinary, thresholds 0.65 and 0.196; `image:` relative to the yaml), each to a temporary name
/// that is then renamed, so that no reader sees half a map. Throws std::runtime_error that names
/// the file and the reason.
void writeMap(const std::string& stem, const MapSnapshot& map);

/// Reads a map written by writeMap or by map_saver. Throws std::runtime_error that names the file
/// and what is wrong with it.
MapSnapshot readMap(const std::string& yaml_path);

}  // namespace kestrel
