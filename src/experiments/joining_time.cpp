// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/joining_time.h"

#include <algorithm>
#include <cmath>

namespace kestrel {
namespace {

constexpr double kNearViewM = 3.0;

double secondsOf(const VehicleMap& map, std::size_t keyframe) {
  return map.keyframes[keyframe].keyframe->time - map.keyframes.front().keyframe->time;
}

double endOf(const VehicleMap& map) { return secondsOf(map, map.keyframes.size() - 1); }

/// Number of keyframes that were there after `seconds`.
std::size_t countAt(const VehicleMap& map, double seconds) {
  std::size_t count = 0;
  while (count < map.keyframes.size() && secondsOf(map, count) <= seconds) ++count;
  return count;
}

/// When a vehicle came near a place for the first time. `poses`: of its keyframes.
std::optional<double> firstNear(const VehicleMap& map, const std::vector<Pose2>& poses,
                                const Pose2& place) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (place.between(poses[i]).distance() <= kNearViewM) return secondsOf(map, i);
  }
  return std::nullopt;
}

/// A keyframe by its number in the joint graph.
struct Numbered {
  std::size_t vehicle, keyframe;
};

Numbered numbered(const std::vector<MappedVehicle>& vehicles, std::size_t vertex) {
  std::size_t vehicle = 0;
  while (vertex >= vehicles[vehicle].map.keyframes.size())
    vertex -= vehicles[vehicle++].map.keyframes.size();
  return {vehicle, vertex};
}

JoiningTime& timeOf(std::vector<JoiningTime>& times, std::size_t a, std::size_t b) {
  return *std::find_if(times.begin(), times.end(), [&](const JoiningTime& time) {
    return time.a == std::min(a, b) && time.b == std::max(a, b);
  });
}

double offOf(const MergeResult& now, const MergeResult& whole, const JoiningTime& time) {
  const std::size_t last = now.poses[time.b].size() - 1;
  const auto between = [&](const MergeResult& result) {
    return result.poses[time.a].front().between(result.poses[time.b][last]);
  };
  return between(whole).between(between(now)).distance();
}

}  // namespace

std::vector<JoiningTime> commonViews(const std::vector<MappedVehicle>& vehicles,
                                     const MergeResult& whole) {
  std::vector<JoiningTime> times;
  for (const PairResult& pair : whole.pairs) {
    times.emplace_back();
    times.back().a = pair.a;
    times.back().b = pair.b;
  }
  for (const PoseEdge& edge : whole.graph.edges) {
    const Numbered from = numbered(vehicles, edge.from), to = numbered(vehicles, edge.to);
    if (from.vehicle == to.vehicle) continue;
    for (const auto& [view, other] : {std::pair{from, to}, std::pair{to, from}}) {
      const std::optional<double> near =
          firstNear(vehicles[other.vehicle].map, whole.poses[other.vehicle],
                    whole.poses[view.vehicle][view.keyframe]);
      if (!near) continue;
      const double both = std::max(*near, secondsOf(vehicles[view.vehicle].map, view.keyframe));
      std::optional<double>& seen = timeOf(times, view.vehicle, other.vehicle).seen_s;
      seen = std::min(seen.value_or(both), both);
    }
  }
  return times;
}

std::vector<JoiningTime> measureJoining(
    const std::vector<MappedVehicle>& vehicles, const SlamConfig& config, double every_s,
    const std::function<void(double, const MergeResult&)>& show) {
  MapMerger at_end(config.mapper, config.loops), merger(config.mapper, config.loops);
  double end = 0.0;
  for (const MappedVehicle& vehicle : vehicles) {
    at_end.update(vehicle.map);
    end = std::max(end, endOf(vehicle.map));
  }
  const MergeResult whole = at_end.merge();
  std::vector<JoiningTime> times = commonViews(vehicles, whole);
  for (double now = every_s; now < end + every_s; now += every_s) {
    for (const MappedVehicle& vehicle : vehicles)
      merger.update(grownTo(vehicle.map, countAt(vehicle.map, now)));
    const MergeResult merged = merger.merge();
    if (show) show(now, merged);
    bool all = true;
    for (JoiningTime& time : times) {
      const bool joined = merged.group[time.a] == merged.group[time.b];
      if (joined && !time.joined_s) {
        time.joined_s = now;
        time.off_m = offOf(merged, whole, time);
      }
      all = all && time.joined_s.has_value();
    }
    if (all) break;
  }
  return times;
}

}  // namespace kestrel
