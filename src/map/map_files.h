// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>

#include "kestrel_slam/map/map_snapshot.h"

namespace kestrel {

class OutputFolder;

/// The contents of the files of a map.
struct MapFiles {
  std::string image;
  std::string yaml;
  std::string yaml_while_saving;  // names a second copy of the image
};

/// Throws std::runtime_error if the map is empty.
MapFiles mapFilesOf(const std::string& stem, const MapSnapshot& map);

/// The names of all files that writeMapFiles may leave.
std::set<std::string> namesOfMap(const std::string& name);

/// Writes `<name>.pgm` and `<name>.yaml` so that the YAML file and the image that it names fit
/// together after every single step.
void writeMapFiles(OutputFolder& folder, const std::string& name, const MapFiles& files);

}  // namespace kestrel
