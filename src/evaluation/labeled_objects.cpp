// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/labeled_objects.h"

#include <cmath>
#include <map>
#include <optional>

#include "kestrel_slam/tracking/object_box.h"

namespace kestrel {
namespace {

/// The labels are drawn by hand: between two frames the speed would be that of the hand.
constexpr double kSpeedWindow = 0.5;
constexpr double kShortest = 0.15;  ///< s

using Sightings = std::vector<LabelSighting>;

std::optional<double> speedAt(const Sightings& path, std::size_t number) {
  const double stamp = path[number].stamp;
  std::size_t first = number, last = number;
  while (first > 0 && stamp - path[first - 1].stamp <= kSpeedWindow) --first;
  while (last + 1 < path.size() && path[last + 1].stamp - stamp <= kSpeedWindow) ++last;
  const double seconds = path[last].stamp - path[first].stamp;
  if (seconds < kShortest) return std::nullopt;
  return (path[last].place - path[first].place).norm() / seconds;
}

LabeledObject objectOf(const Sightings& path, const LabelGoal& goal) {
  LabeledObject object;
  object.id = path.front().id;
  object.type = path.front().type;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const std::optional<double> speed = speedAt(path, i);
    if (!speed || *speed <= goal.min_speed || path[i].points < goal.min_points) continue;
    ++object.sweeps;
    object.speed += (*speed - object.speed) / static_cast<double>(object.sweeps);
    if (path[i].is_shown) {
      ++object.shown;
      object.tracks.insert(path[i].track);
    } else if (path[i].has_track) {
      ++object.hidden;
    }
  }
  return object;
}

}  // namespace

bool isInLabel(const KittiLabel& label, const Eigen::Vector3d& point, double margin) {
  const OrientedBox box{label.center.head<2>(), label.size.head<2>(), label.yaw};
  return box.contains(point.head<2>(), margin) &&
         std::abs(point.z() - label.center.z()) <= 0.5 * label.size.z() + margin;
}

std::vector<LabeledObject> labeledObjects(const Sightings& sightings, const LabelGoal& goal) {
  std::map<long, Sightings> paths;
  for (const LabelSighting& sighting : sightings) paths[sighting.id].push_back(sighting);
  std::vector<LabeledObject> objects;
  for (const auto& [id, path] : paths) {
    const LabeledObject object = objectOf(path, goal);
    if (object.sweeps > 0) objects.push_back(object);
  }
  return objects;
}

}  // namespace kestrel
