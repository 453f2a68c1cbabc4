// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/joining_time.h"

#include <algorithm>

#include "kestrel_slam/merging/joint_map.h"
#include "kestrel_slam/merging/overlap.h"

namespace kestrel {
namespace {

double secondsOf(const VehicleMap& map, std::size_t keyframe) {
  return map.keyframes[keyframe].keyframe->time - map.keyframes.front().keyframe->time;
}

VehicleMap mapAt(const VehicleMap& map, double seconds) {
  std::size_t count = 0;
  while (count < map.keyframes.size() && secondsOf(map, count) <= seconds) ++count;
  return grownTo(map, count);
}

/// Finds common views, with the poses of the end.
class CommonViews {
 public:
  CommonViews(const SlamConfig& config, const MergeResult& whole)
      : config_(config.mapper), matcher_(config.mapper.matcher, config.loops), whole_(whole) {}

  void look(const std::vector<VehicleMap>& maps, double now, std::vector<JoiningTime>& times) {
    std::vector<const VehicleMap*> pointers;
    std::vector<PoseVertex> poses;
    for (std::size_t v = 0; v < maps.size(); ++v) {
      pointers.push_back(&maps[v]);
      for (std::size_t i = 0; i < maps[v].poses.size(); ++i) poses.push_back({whole_.poses[v][i]});
    }
    JointMap joint(config_, pointers);
    const auto sees = [&](std::size_t a, std::size_t b) {
      return !compareOverlap(joint, matcher_, poses, a, b, memory_).agreeing.empty();
    };
    for (JoiningTime& time : times) {
      const bool together = whole_.group[time.a] == whole_.group[time.b];
      if (together && !time.seen_s && (sees(time.a, time.b) || sees(time.b, time.a)))
        time.seen_s = now;
    }
  }

 private:
  MapperConfig config_;
  LoopMatcher matcher_;
  const MergeResult& whole_;
  SearchMemory memory_;
};

double offOf(const MergeResult& now, const MergeResult& whole, const JoiningTime& time) {
  const std::size_t last = now.poses[time.b].size() - 1;
  const auto between = [&](const MergeResult& result) {
    return result.poses[time.a].front().between(result.poses[time.b][last]);
  };
  return between(whole).between(between(now)).distance();
}

}  // namespace

std::vector<JoiningTime> measureJoining(const std::vector<MappedVehicle>& vehicles,
                                        const SlamConfig& config, double every_s) {
  MapMerger at_end(config.mapper, config.loops), merger(config.mapper, config.loops);
  double end = 0.0;
  for (const MappedVehicle& vehicle : vehicles) {
    at_end.update(vehicle.map);
    end = std::max(end, secondsOf(vehicle.map, vehicle.map.keyframes.size() - 1));
  }
  const MergeResult whole = at_end.merge();
  std::vector<JoiningTime> times;
  for (const PairResult& pair : whole.pairs) {
    times.emplace_back();
    times.back().a = pair.a;
    times.back().b = pair.b;
  }
  CommonViews views(config, whole);
  const auto isOpen = [](const JoiningTime& time) { return !time.joined_s; };
  for (double now = every_s; now < end + every_s && std::any_of(times.begin(), times.end(), isOpen);
       now += every_s) {
    std::vector<VehicleMap> maps;
    for (const MappedVehicle& vehicle : vehicles) maps.push_back(mapAt(vehicle.map, now));
    views.look(maps, now, times);
    for (VehicleMap& map : maps) merger.update(std::move(map));
    const MergeResult merged = merger.merge();
    for (JoiningTime& time : times) {
      if (!isOpen(time) || merged.group[time.a] != merged.group[time.b]) continue;
      time.joined_s = now;
      time.off_m = offOf(merged, whole, time);
    }
  }
  return times;
}

}  // namespace kestrel
