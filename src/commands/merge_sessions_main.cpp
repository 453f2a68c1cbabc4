// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "kestrel_slam/commands/mapping_command.h"
#include "kestrel_slam/commands/run_tool.h"
#include "kestrel_slam/map/atomic_file.h"
#include "kestrel_slam/map/map_folder.h"
#include "kestrel_slam/merging/flight_settings.h"
#include "kestrel_slam/merging/merged_session.h"
#include "kestrel_slam/offline/provenance.h"
#include "kestrel_slam/offline/stats.h"
#include "kestrel_slam/parameters/parameters_yaml.h"
#include "kestrel_slam/recording/trajectory.h"
#include "kestrel_slam/report/map_image.h"
#include "kestrel_slam/report/plot.h"
#include "kestrel_slam/session/session_file.h"
#include "kestrel_slam/session/version.h"

namespace kestrel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kStyle =
#include "../report/page/style.css.inc"
    ;
constexpr const char* kPage =
#include "merged_page.html.inc"
    ;

struct Options {
  std::vector<std::string> sessions, starts, joins, separated, settings;
  std::string output, cache, before;
};

/// "uav0=file" or "file": then the name is that of the file, without its ending.
std::pair<std::string, std::string> nameAndFile(const std::string& argument) {
  const std::size_t equal = argument.find('=');
  if (equal == std::string::npos || fs::exists(argument))
    return {fs::path(argument).stem().string(), argument};
  return {argument.substr(0, equal), argument.substr(equal + 1)};
}

/// "uav0=x,y,yaw", m and degrees.
std::map<std::string, Pose2> startsOf(const char* option, const std::vector<std::string>& texts) {
  std::map<std::string, Pose2> starts;
  for (const std::string& text : texts) {
    double x = 0.0, y = 0.0, yaw = 0.0;
    const std::size_t equal = text.find('=');
    char rest = 0;
    if (equal == std::string::npos ||
        std::sscanf(text.c_str() + equal + 1, "%lf,%lf,%lf%c", &x, &y, &yaw, &rest) != 3)
      throw CLI::ValidationError(option, "'" + text + "' is not NAME=x,y,yaw");
    starts[text.substr(0, equal)] = Pose2(x, y, degToRad(yaw));
  }
  return starts;
}

const VehicleMap& named(const std::vector<VehicleMap>& vehicles, const std::string& name,
                        const std::string& option) {
  for (const VehicleMap& vehicle : vehicles)
    if (vehicle.name == name) return vehicle;
  throw std::runtime_error(option + " names " + name + ", which is no session");
}

/// Where `world` is while the flight whose map it was is missing, as after two restarts.
void keepWorld(const Json& before, const std::vector<VehicleMap>& vehicles,
               FlightSettings& settings) {
  const std::string flight = flightOf(vehicles.front());
  const Json& old = before.at("vehicles");
  if (settings.starts.count(flight) > 0 || flight == old.at(0).at("flight")) return;
  for (const Json& vehicle : old) {
    if (vehicle.at("flight") != flight || vehicle.at("group") != old.at(0).at("group")) continue;
    const Json& pose = vehicle.at("world_T_map");
    settings.starts[flight] = {"", Pose2(pose.at("x"), pose.at("y"), pose.at("yaw"))};
  }
}

/// What the user said until the merge whose merge_status.json this is. Brings the vehicles into the
/// order of then.
FlightSettings settingsBefore(const std::string& path, std::vector<VehicleMap>& vehicles) {
  FlightSettings settings;
  if (!fs::exists(path)) return settings;
  try {
    const Json before = Json::parse(readFile(path));
    if (!before.contains("settings")) return settings;  // of an older version
    for (const Json& vehicle : before.at("vehicles"))
      settings.order.push_back(vehicle.at("flight"));
    for (const Json& start : before.at("settings").at("starts"))
      settings.starts[start.at("flight")] = {start.at("name"),
                                             Pose2(start.at("x"), start.at("y"), start.at("yaw"))};
    for (const Json& pair : before.at("settings").at("separated"))
      settings.separated.emplace(pair.at(0), pair.at(1));
    if (!settings.isOf(vehicles)) return {};
    settings.sort(vehicles);
    keepWorld(before, vehicles, settings);
  } catch (const Json::exception&) {
    throw std::runtime_error(path + ": is no merge_status.json; move it away");
  }
  return settings;
}

std::vector<VehicleMap> readVehicles(const Options& options) {
  std::vector<VehicleMap> vehicles;
  for (const std::string& argument : options.sessions) {
    const auto [name, file] = nameAndFile(argument);
    vehicles.push_back(vehicleMapOf(name, loadSession(file)));
  }
  const std::string problem = problemOf(vehicles);
  if (!problem.empty()) throw std::runtime_error(problem);
  return vehicles;
}

/// "NAME,NAME"
void separate(const std::string& text, const std::vector<VehicleMap>& vehicles,
              FlightSettings& settings) {
  const std::size_t comma = std::min(text.find(','), text.size() - 1);
  const std::string first = text.substr(0, comma), second = text.substr(comma + 1);
  if (first == second || first.empty() || second.empty())
    throw std::runtime_error("--separate " + text + " does not name two of the vehicles");
  settings.separate(named(vehicles, first, "--separate"), named(vehicles, second, "--separate"));
}

FlightSettings settingsOf(const Options& options, std::vector<VehicleMap>& vehicles) {
  FlightSettings settings = settingsBefore(options.before, vehicles);
  for (const auto& [name, pose] : startsOf("--start", options.starts))
    settings.start(named(vehicles, name, "--start"), pose);
  for (const auto& [name, pose] : startsOf("--join", options.joins))
    settings.join(named(vehicles, name, "--join"), pose);
  for (const std::string& pair : options.separated) separate(pair, vehicles, settings);
  settings.apply(vehicles);
  return settings;
}

Json jsonOf(const Pose2& pose) {
  return {{"x", rounded(pose.x, 4)}, {"y", rounded(pose.y, 4)}, {"yaw", rounded(pose.yaw, 5)}};
}

Json jsonOf(const FlightSettings& settings) {
  Json json = {{"starts", Json::array()}, {"separated", Json::array()}};
  for (const auto& [flight, start] : settings.starts) {
    const Pose2& pose = start.world_T_map;
    json["starts"].push_back({{"flight", flight},
                              {"name", start.name},
                              {"x", pose.x},
                              {"y", pose.y},
                              {"yaw", pose.yaw}});
  }
  for (const auto& [a, b] : settings.separated) json["separated"].push_back({a, b});
  return json;
}

Json statusOf(const std::vector<VehicleMap>& vehicles, const MergeResult& merged) {
  Json status;
  for (std::size_t v = 0; v < vehicles.size(); ++v) {
    status["vehicles"].push_back({{"name", vehicles[v].name},
                                  {"flight", flightOf(vehicles[v])},
                                  {"keyframes", vehicles[v].keyframes.size()},
                                  {"group", vehicles[merged.group[v]].name},
                                  {"world_T_map", jsonOf(merged.world_T_map[v])}});
  }
  status["pairs"] = Json::array();
  for (const PairResult& pair : merged.pairs) {
    Json entry = {{"a", vehicles[pair.a].name},
                  {"b", vehicles[pair.b].name},
                  {"state", toString(pair.state)},
                  {"reason", pair.reason},
                  {"confidence", rounded(pair.confidence, 3)},
                  {"searched", pair.searched},
                  {"found", pair.found},
                  {"agreeing", pair.first},
                  {"second_explanation", pair.second},
                  {"places", pair.places},
                  {"common_keyframes", pair.compared},
                  {"contradicting_keyframes", pair.contradicting},
                  {"longest_contradiction_m", rounded(pair.longest_contradiction_m, 2)},
                  {"differing_wall_m", rounded(pair.differing_wall_m, 2)}};
    if (pair.isJoined()) entry["a_T_b"] = jsonOf(pair.a_T_b);
    status["pairs"].push_back(entry);
  }
  status["loops_between"] = merged.loops_between;
  return status;
}

Trajectory trajectoryOf(const VehicleMap& vehicle, const std::vector<Pose2>& poses) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < poses.size(); ++i)
    trajectory.push_back({vehicle.keyframes[i].keyframe->stamp, poses[i]});
  return trajectory;
}

/// The walls and the way of each vehicle.
void drawMerged(const fs::path& folder, const std::vector<VehicleMap>& vehicles,
                const MergeResult& merged, const MapSnapshot& map) {
  PlotPanel panel;
  panel.title = "merged map and the ways of the vehicles";
  panel.x_label = "x in world, m";
  panel.y_label = "y in world, m";
  panel.equal_axes = true;
  PlotSeries walls{"walls", {}, PlotSeries::Style::kDots, kPlotBlack};
  for (int row = 0; row < map.height; ++row) {
    for (int column = 0; column < map.width; ++column) {
      if (map.at(column, row) != MapSnapshot::kOccupied) continue;
      walls.points.emplace_back(map.origin_x + (column + 0.5) * map.resolution_m,
                                map.origin_y + (row + 0.5) * map.resolution_m);
    }
  }
  panel.series.push_back(std::move(walls));
  for (std::size_t v = 0; v < vehicles.size(); ++v) {
    if (merged.group[v] != merged.group[0]) continue;
    PlotSeries way{vehicles[v].name, {}, PlotSeries::Style::kLine, v};
    for (const Pose2& pose : merged.poses[v]) way.points.push_back(pose.translation());
    panel.series.push_back(std::move(way));
  }
  writePlot((folder / "merged.png").string(), {panel});
}

Json wayOf(const std::vector<Pose2>& poses) {
  Json x = Json::array(), y = Json::array();
  double length = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    x.push_back(rounded(poses[i].x, 3));
    y.push_back(rounded(poses[i].y, 3));
    if (i > 0) length += poses[i - 1].between(poses[i]).distance();
  }
  return {{"x", x}, {"y", y}, {"length_m", rounded(length, 2)}};
}

/// A page with the map, the ways of the vehicles, and a table of the pairs.
std::string reportOf(const Json& status, const MergeResult& merged, const MapSnapshot& map) {
  const MapImage image = renderMap(map);
  Json data = {{"status", status}, {"version", kVersion}, {"ways", Json::array()}};
  for (const std::vector<Pose2>& poses : merged.poses) data["ways"].push_back(wayOf(poses));
  data["map"] = {{"png", "data:image/png;base64," + base64(image.png)},
                 {"width", image.width},
                 {"height", image.height},
                 {"metersPerPixel", map.resolution_m * image.cells_per_pixel},
                 {"originX", map.origin_x},
                 {"originY", map.origin_y}};
  std::string json;  // "</script>" in a name must not end the element
  for (const char c : data.dump(-1, ' ', false, Json::error_handler_t::replace))
    json += c == '<' ? "\\u003c" : std::string(1, c);
  const std::string page = kPage;
  const std::size_t script = page.find("<script>");
  return std::string("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n") +
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n" +
         "<title>Merged sessions</title>\n<style>" + kStyle + "</style>\n</head>\n" +
         page.substr(0, script) + "<script type=\"application/json\" id=\"data\">" + json +
         "</script>\n" + page.substr(script);
}

void printPairs(const std::vector<VehicleMap>& vehicles, const MergeResult& merged) {
  for (const PairResult& pair : merged.pairs) {
    std::printf("%s and %s: %s, confidence %.2f (%s)\n", vehicles[pair.a].name.c_str(),
                vehicles[pair.b].name.c_str(), toString(pair.state), pair.confidence,
                pair.reason.c_str());
  }
}

void run(const Options& options) {
  SlamConfig config;
  applySettings(options.settings, config);
  MapMerger merger(config.mapper, config.loops);
  std::vector<VehicleMap> maps = readVehicles(options);
  const FlightSettings settings = settingsOf(options, maps);
  for (VehicleMap& map : maps) merger.update(std::move(map));
  for (std::size_t b = 0; b < maps.size(); ++b)
    for (std::size_t a = 0; a < b; ++a)
      if (settings.areSeparated(merger.vehicles()[a], merger.vehicles()[b])) merger.separate(a, b);
  prepareOutput(options.output);
  const std::string made_by = std::string(kVersion) + " " + builtCommit() + parametersYaml(config);
  if (fs::exists(options.cache)) merger.memory().decode(readFile(options.cache), made_by);
  const MergeResult merged = merger.merge();
  if (!options.cache.empty()) writeFileAtomically(options.cache, merger.memory().encode(made_by));
  const std::vector<VehicleMap>& vehicles = merger.vehicles();
  const MapSnapshot map = mapOf(vehicles, merged, 0, config.mapper.grid);
  Session session = mergedSession(vehicles, merged, 0);
  session.written_by = std::string("kestrel_slam ") + kVersion;
  session.resolution_m = config.mapper.grid.resolution_m;
  session.parameters = parametersYaml(config);
  Json status = statusOf(vehicles, merged);
  status["settings"] = jsonOf(settings);
  std::vector<NamedContent> files = {{"merged.session", encodeSession(session)},
                                     {"merge_status.json", status.dump(2) + "\n"},
                                     {"report.html", reportOf(status, merged, map)}};
  for (std::size_t v = 0; v < vehicles.size(); ++v)
    files.push_back({"trajectory_" + vehicles[v].name + ".tum",
                     tumText(trajectoryOf(vehicles[v], merged.poses[v]))});
  writeMapFolder(options.output, map, files);
  drawMerged(options.output, vehicles, merged, map);
  printPairs(vehicles, merged);
}

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  using namespace kestrel;
  CLI::App app(
      "Merges the sessions of several vehicles into one map, where they have mapped the same "
      "place.\n"
      "Writes merged.session, map.pgm, map.yaml, trajectory_NAME.tum for every vehicle (one that "
      "is not joined with the first one keeps its own frame), merge_status.json, merged.png and "
      "report.html.\n"
      "Exit code 0: done, also if nothing was joined; 1: bad input; 2: wrong usage.");
  Options options;
  app.add_option("SESSION", options.sessions,
                 "two or more session files, or NAME=FILE; NAME is that of the vehicle")
      ->required()
      ->expected(2, 1000);
  app.add_option("--output", options.output, "folder for the results")->required();
  app.add_option("--start", options.starts,
                 "NAME=x,y,yaw: about where the map of this vehicle begins in world, m and degrees")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  app.add_option(
         "--join", options.joins,
         "NAME=x,y,yaw: the same for the map that this vehicle has now, with --before; it is "
         "separated from no other one any more")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--separate", options.separated, "NAME,NAME: never join these two directly")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  app.add_option(
      "--before", options.before,
      "FILE: merge_status.json of the last merge of these vehicles: world stays where it "
      "is, and what was said with --start, --join and --separate stays true for the "
      "flights of then, when a vehicle has begun a new map under its name");
  app.add_option("--cache", options.cache,
                 "FILE: results of searches, for the next time that these sessions are merged when "
                 "they have grown; the result is the same without it");
  app.add_option("--set", options.settings, "name=value: sets a parameter")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  return runTool("merge_sessions", app, argc, argv, [&] { run(options); });
}
