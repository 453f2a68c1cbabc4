// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/session/finished_map.h"

#include <filesystem>
#include <stdexcept>

#include "kestrel_slam/map/map_io.h"
#include "kestrel_slam/map/picture_map.h"
#include "kestrel_slam/session/session_file.h"

namespace kestrel {
namespace {

bool isPicture(const std::string& file) {
  const std::string ending = std::filesystem::path(file).extension().string();
  return ending == ".pgm" || ending == ".png";
}

void requireFile(const std::string& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw std::runtime_error(file + ": does not exist");
  if (std::filesystem::is_directory(file, error))
    throw std::runtime_error(file + ": is a folder; give the session or the YAML file of a map");
  if (isPicture(file))
    throw std::runtime_error(file + ": is a picture; give its YAML file, which has its scale");
}

}  // namespace

Submap submapOf(const Session& session, const OccupancyGridConfig& config) {
  OccupancyGridConfig grid = config;
  grid.resolution_m = session.resolution_m;
  return submapOf(mapKeyframes(session), grid);
}

Submap loadFinishedMap(const std::string& file, const OccupancyGridConfig& config) {
  requireFile(file);
  Submap result =
      isSessionFile(file) ? submapOf(loadSession(file), config) : submapOf(readMap(file), config);
  if (result.surface().size() == 0) throw std::runtime_error(file + ": the map has no walls");
  if (result.isFull())
    throw std::runtime_error(file + ": the map is larger than map_memory_limit_mb");
  return result;
}

}  // namespace kestrel
