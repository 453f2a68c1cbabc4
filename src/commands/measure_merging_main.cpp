// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/experiments/height_measurement.h"
#include "kestrel_slam/experiments/joining_time.h"
#include "kestrel_slam/experiments/merging_measurement.h"
#include "kestrel_slam/experiments/processor_time.h"
#include "kestrel_slam/graph/optimizer.h"
#include "kestrel_slam/map/map_io.h"
#include "kestrel_slam/merging/merged_session.h"
#include "kestrel_slam/parameters/parameters_yaml.h"
#include "kestrel_slam/session/session_file.h"

namespace kestrel {
namespace {

struct Options {
  std::vector<std::string> recordings;
  std::string relations, reference, output, odometry = "none";
  std::vector<std::string> settings;
  std::size_t parts = 1, offices = 0, steps = 0, rooms = 0, heights = 0;
  double every_s = 0.0;
};

SlamConfig configOf(const Options& options) {
  SlamConfig config;
  applySettings(options.settings, config);
  return config;
}

std::vector<MappedVehicle> mapAll(const Options& options) {
  std::vector<MappedVehicle> vehicles;
  for (const std::string& path : options.recordings) {
    for (const VehicleRecording& part :
         cutRecording(path, options.parts, options.odometry == "use")) {
      const double begin = processorSeconds();
      vehicles.push_back(mapVehicle(part, configOf(options)));
      std::fprintf(stderr, "%s: %zu scans, %zu keyframes, %zu places, mapped in %.1f s\n",
                   part.name.c_str(), vehicles.back().trajectory.size(),
                   vehicles.back().map.keyframes.size(), vehicles.back().map.places.size(),
                   processorSeconds() - begin);
    }
  }
  return vehicles;
}

void printPairHead() {
  std::printf("%-16s %-16s %-16s %6s %7s %6s %5s %6s %6s %8s %6s %7s %6s %6s  %s\n", "a", "b",
              "state", "conf", "queries", "found", "first", "second", "places", "compared", "not",
              "along m", "wall m", "s", "reason");
}

void printPair(const MapMerger& merger, const PairResult& pair, double seconds) {
  std::printf("%-16s %-16s %-16s %6.3f %7zu %6zu %5zu %6zu %6zu %8zu %6zu %7.1f %6.1f %6.1f  %s\n",
              merger.vehicles()[pair.a].name.c_str(), merger.vehicles()[pair.b].name.c_str(),
              toString(pair.state), pair.confidence, pair.searched, pair.found, pair.first,
              pair.second, pair.places, pair.compared, pair.contradicting,
              pair.longest_contradiction_m, pair.differing_wall_m, seconds, pair.reason.c_str());
  std::fflush(stdout);
}

/// Merges two maps and prints the result. Returns whether they were joined.
bool measurePair(const SlamConfig& config, const MappedVehicle& a, const MappedVehicle& b) {
  MapMerger merger(config.mapper, config.loops);
  merger.update(a.map);
  merger.update(b.map);
  const double begin = processorSeconds();
  const MergeResult result = merger.merge();
  printPair(merger, result.pairs.front(), processorSeconds() - begin);
  return result.pairs.front().isJoined();
}

/// Every two of the recordings alone.
void measurePairs(const Options& options, const std::vector<MappedVehicle>& vehicles) {
  const SlamConfig config = configOf(options);
  std::size_t pairs = 0, joined = 0;
  printPairHead();
  for (std::size_t b = 0; b < vehicles.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a, ++pairs)
      joined += measurePair(config, vehicles[a], vehicles[b]) ? 1 : 0;
  }
  std::printf("%zu pairs, %zu joined\n", pairs, joined);
}

/// Two vehicles in the same office, and in offices that differ in one room.
void measureOffices(const Options& options) {
  const SlamConfig config = configOf(options);
  constexpr OfficeChange kChanges[] = {OfficeChange::kNone, OfficeChange::kFurniture,
                                       OfficeChange::kShallow, OfficeChange::kDeep,
                                       OfficeChange::kPartition};
  std::map<OfficeChange, std::size_t> joined;
  printPairHead();
  for (std::uint64_t seed = 1; seed <= options.offices; ++seed) {
    const MappedVehicle first = mapOffice(seed, OfficeChange::kNone, 1, config);
    for (const OfficeChange change : kChanges) {
      std::printf("%-15s ", toString(change));
      joined[change] += measurePair(config, first, mapOffice(seed, change, 2, config)) ? 1 : 0;
    }
  }
  for (const OfficeChange change : kChanges)
    std::printf("%-16s %zu of %zu joined\n", toString(change), joined[change], options.offices);
}

/// How many pairs of one kind were joined, with and without the heights, and the largest error.
struct JoinedPairs {
  std::size_t pairs = 0, with = 0, without = 0;
  double error_m = 0.0;
};

/// Vehicles that fly at different heights in the same building, and in buildings that differ.
void measureHeights(const Options& options) {
  constexpr double kRightMapM = 0.3;
  const SlamConfig config = configOf(options);
  std::map<std::string, JoinedPairs> counts;
  std::printf("%-22s %-20s %-16s %-16s %8s %8s  %s\n", "buildings", "flights", "without heights",
              "with heights", "error m", "wall m", "reason");
  for (std::uint64_t seed = 1; seed <= options.heights; ++seed) {
    const FlightsAtHeights flights(seed, config);
    for (const PairAtHeights& pair : flights.pairs()) {
      const auto [with, without] = mergeAtHeights(pair, config);
      std::printf("%-22s %-20s %-16s %-16s %8.3f %8.1f  %s\n", pair.where.c_str(),
                  pair.flying.c_str(), toString(without.result.state), toString(with.result.state),
                  with.error_m, with.result.differing_wall_m, with.result.reason.c_str());
      std::fflush(stdout);
      // A map that is wrong itself need not be joined.
      const bool is_right = std::max(pair.a->error(), pair.b->error()) < kRightMapM;
      JoinedPairs& count = counts[pair.where + (is_right ? "" : ", own map wrong")];
      ++count.pairs;
      count.with += with.result.isJoined() ? 1 : 0;
      count.without += without.result.isJoined() ? 1 : 0;
      count.error_m = std::max(count.error_m, with.error_m);
    }
  }
  for (const auto& [where, count] : counts)
    std::printf("%-40s %zu of %zu joined, %zu without heights, error up to %.3f m\n", where.c_str(),
                count.with, count.pairs, count.without, count.error_m);
}

Trajectory allInWorld(const std::vector<MappedVehicle>& vehicles, const MergeResult& result) {
  Trajectory all;
  for (std::size_t v = 0; v < vehicles.size(); ++v) {
    const Trajectory part = inWorld(vehicles[v], result, v);
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

void printReference(const Options& options, const std::vector<MappedVehicle>& vehicles,
                    const MergeResult& result) {
  const auto print = [&](const char* name, const Trajectory& trajectory) {
    const ReferenceEvaluation errors = evaluateReference(trajectory, readTum(options.reference));
    std::printf("%-16s ATE rmse %.2f m, max %.2f m\n", name,
                errors.ate_statistics.translation_m.rmse, errors.ate_statistics.translation_m.max);
  };
  for (const MappedVehicle& vehicle : vehicles) print(vehicle.map.name.c_str(), vehicle.trajectory);
  print("all in world", allInWorld(vehicles, result));
}

void printErrors(const Options& options, const std::vector<MappedVehicle>& vehicles,
                 const MergeResult& result) {
  const Trajectory all = allInWorld(vehicles, result);
  std::vector<double> first;
  for (const MappedVehicle& vehicle : vehicles) first.push_back(vehicle.trajectory.front().stamp);
  const std::vector<Relation> relations = readRelations(options.relations);
  const auto vehicleAt = [&](double stamp) {
    std::size_t vehicle = 0;
    while (vehicle + 1 < first.size() && stamp >= first[vehicle + 1] - kStampTolerance) ++vehicle;
    return vehicle;
  };
  std::vector<Relation> across;
  for (const Relation& relation : relations) {
    if (vehicleAt(relation.stamp1) != vehicleAt(relation.stamp2)) across.push_back(relation);
  }
  const auto print = [&](const char* name, const std::vector<Relation>& some) {
    const RelationEvaluation errors = evaluateRelations(all, some);
    std::printf("%-8s %zu relations, mean %.4f m, max %.3f m, %.3f deg, %zu unmatched\n", name,
                errors.all.translation_m.count, errors.all.translation_m.mean,
                errors.all.translation_m.max, errors.all.rotation_deg.mean,
                errors.skipped_relations);
  };
  print("all", relations);
  print("across", across);
}

/// How long after the first common view the vehicles are joined, if all fly at the same time.
void measureJoiningTimes(const Options& options, const std::vector<MappedVehicle>& vehicles) {
  const auto text = [](const std::optional<double>& seconds) {
    return seconds ? std::to_string(static_cast<long>(*seconds)) : std::string("never");
  };
  const auto times = measureJoining(vehicles, configOf(options), options.every_s);
  std::printf("%-16s %-16s %14s %10s %8s %8s\n", "a", "b", "common view s", "joined s", "later s",
              "off m");
  for (const JoiningTime& time : times) {
    std::printf("%-16s %-16s %14s %10s %8s %8.3f\n", vehicles[time.a].map.name.c_str(),
                vehicles[time.b].map.name.c_str(), text(time.seen_s).c_str(),
                text(time.joined_s).c_str(), text(time.later()).c_str(), time.off_m);
  }
}

void measureParts(const Options& options, const std::vector<MappedVehicle>& vehicles) {
  const SlamConfig config = configOf(options);
  MapMerger merger(config.mapper, config.loops);
  for (const MappedVehicle& vehicle : vehicles) merger.update(vehicle.map);
  const double begin = processorSeconds();
  const MergeResult result = merger.merge();
  const double seconds = processorSeconds() - begin;
  printPairHead();
  for (const PairResult& pair : result.pairs) printPair(merger, pair, seconds);
  std::printf("%zu of %zu vehicles in one map, %zu loops between them\n", result.largestGroup(),
              vehicles.size(), result.loops_between);
  if (!options.relations.empty()) printErrors(options, vehicles, result);
  if (!options.reference.empty()) printReference(options, vehicles, result);
  if (options.output.empty()) return;
  std::filesystem::create_directories(options.output);
  writeMap(options.output + "/map", mapOf(merger.vehicles(), result, 0, config.mapper.grid));
}

/// Writes the sessions of four vehicles in one large office.
void writeSessions(const Options& options) {
  constexpr std::uint64_t kVehicles = 4;
  std::filesystem::create_directories(options.output);
  for (std::uint64_t vehicle = 1; vehicle <= kVehicles; ++vehicle) {
    const Session session = officeSession(1, vehicle, options.rooms, configOf(options));
    const std::string file = options.output + "/uav" + std::to_string(vehicle) + ".session";
    saveSession(file, session);
    std::printf("%s: %zu keyframes\n", file.c_str(), session.keyframes.size());
    std::fflush(stdout);
  }
}

double lengthOf(const VehicleMap& map) {
  double length = 0.0;
  for (std::size_t i = 1; i < map.poses.size(); ++i)
    length += map.poses[i - 1].between(map.poses[i]).distance();
  return length;
}

/// Places the keyframes as each vehicle has mapped them, as before they are optimized.
void placeAsMapped(const MapMerger& merger, MergeResult& result) {
  std::size_t vertex = 0;
  for (std::size_t v = 0; v < merger.vehicles().size(); ++v) {
    for (const Pose2& pose : merger.vehicles()[v].poses)
      result.graph.vertices[vertex++].pose = result.world_T_map[v] * pose;
  }
}

/// Merges the sessions while they grow.
void measureSteps(const Options& options) {
  const SlamConfig config = configOf(options);
  std::vector<VehicleMap> maps;
  for (const std::string& path : options.recordings)
    maps.push_back(vehicleMapOf(std::filesystem::path(path).stem().string(), loadSession(path)));
  MapMerger merger(config.mapper, config.loops);
  std::printf("%8s %10s %8s %9s %8s %8s\n", "m", "keyframes", "joined", "searches", "s", "s joint");
  for (std::size_t step = 1; step <= options.steps; ++step) {
    double length = 0.0;
    std::size_t keyframes = 0;
    for (const VehicleMap& map : maps) {
      VehicleMap grown =
          grownTo(map, (map.keyframes.size() * step + options.steps / 2) / options.steps);
      length += lengthOf(grown);
      keyframes += grown.keyframes.size();
      merger.update(std::move(grown));
    }
    const std::size_t searches = merger.memory().searches();
    const double begin = processorSeconds();
    MergeResult result = merger.merge();
    const double seconds = processorSeconds() - begin;
    placeAsMapped(merger, result);
    const double joint_begin = processorSeconds();
    optimize(result.graph, jointOptions());
    std::printf("%8.0f %10zu %8zu %9zu %8.2f %8.2f\n", length, keyframes, result.largestGroup(),
                merger.memory().searches() - searches, seconds, processorSeconds() - joint_begin);
    std::fflush(stdout);
  }
}

void run(const Options& options) {
  if (options.rooms > 0) return writeSessions(options);
  if (options.steps > 0) return measureSteps(options);
  if (options.offices > 0) return measureOffices(options);
  if (options.heights > 0) return measureHeights(options);
  const std::vector<MappedVehicle> vehicles = mapAll(options);
  if (options.parts > 1 && options.every_s > 0.0) {
    measureJoiningTimes(options, vehicles);
  } else if (options.parts > 1) {
    measureParts(options, vehicles);
  } else {
    measurePairs(options, vehicles);
  }
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app(
      "Measures how maps of several vehicles are merged. With --parts the recordings are cut in "
      "time into vehicles that do not know where they started; otherwise every two recordings are "
      "tried, as maps of different buildings. With --offices, two vehicles fly through simulated "
      "offices: the same one, and two that differ in one room.\n"
      "Exit code 0: done; 1: bad input; 2: wrong usage.");
  Options options;
  app.add_option("RECORDING", options.recordings, "recordings");
  CLI::Option* output = app.add_option("--output", options.output,
                                       "folder for the merged map, with --parts; see --rooms");
  app.add_option("--offices", options.offices, "N: number of simulated offices");
  app.add_option(
      "--heights", options.heights,
      "N: number of simulated buildings whose doors have lintels, in which vehicles fly at "
      "different heights; also buildings that differ in a door or a wall");
  app.add_option("--rooms", options.rooms,
                 "N: writes the sessions of four simulated vehicles in an office of N rooms to "
                 "--output; 90 rooms are 1 km")
      ->needs(output);
  app.add_option(
      "--steps", options.steps,
      "N: RECORDING are sessions of vehicles; their maps grow in N steps, and are merged "
      "after each");
  app.add_option("--parts", options.parts, "N: number of vehicles that a recording is cut into")
      ->check(CLI::Range(1, 100));
  app.add_option("--every", options.every_s,
                 "S: with --parts, all vehicles fly at the same time, and their maps are merged "
                 "every S seconds; prints how long after the first common view they are joined");
  app.add_option("--relations", options.relations, "relations of the recording, with --parts");
  app.add_option("--reference", options.reference,
                 "trajectory of the recording (TUM format), with --parts");
  app.add_option("--odometry", options.odometry, "none: laser only (default); use: where recorded")
      ->check(CLI::IsMember({"none", "use"}));
  app.add_option("--set", options.settings, "name=value: sets a parameter")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  return runTool(
      "measure_merging", app, argc, argv, [&] { run(options); },
      [&] {
        if (options.recordings.empty() == (options.offices + options.heights + options.rooms == 0))
          throw CLI::RequiredError("RECORDING, --offices, --heights or --rooms");
      });
}
