// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/report.h"

#include <cstdio>
#include <map>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/report/map_image.h"
#include "kestrel_slam/report/series.h"
#include "kestrel_slam/session/version.h"
#include "page_data.h"

namespace kestrel {
namespace {

using Json = nlohmann::ordered_json;

// The page consists of four files, which are raw string literals and compiled into the library.
constexpr const char* kStyle =
#include "page/style.css.inc"
    ;
constexpr const char* kBody =
#include "page/body.html.inc"
    ;
constexpr const char* kMapScript =
#include "page/map.js.inc"
    ;
constexpr const char* kPageScript =
#include "page/page.js.inc"
    ;

constexpr std::size_t kMaxPoints = 5000;  // per curve
constexpr int kMillimeter = 3;            // decimals

struct Cell {
  double value;
  int decimals;
  const char* unit;
};

std::string text(const Cell& cell) {
  constexpr std::size_t kLength = 64;
  char buffer[kLength];
  std::snprintf(buffer, sizeof buffer, "%.*f%s", cell.decimals, cell.value, cell.unit);
  return buffer;
}

std::string droppedText(const OfflineRun& run) {
  if (run.dropped.empty()) return "none";
  std::string result;
  for (const auto& [reason, count] : run.dropped) {
    result += (result.empty() ? "" : ", ") + std::to_string(count) + " " + reason;
  }
  return result;
}

/// Adds an array of two strings. (A brace list would be parsed as an object by nlohmann::json.)
void addRow(Json& rows, const std::string& first, const std::string& second) {
  rows.push_back(Json::array({first, second}));
}

void addMatchRows(Json& rows, const OfflineRun& run) {
  const MatchSummary match = summarize(run.scans);
  const double percent = run.scans.empty() ? 0.0 : 100.0 / static_cast<double>(run.scans.size());
  const auto share = [percent](std::size_t count) {
    return text({percent * static_cast<double>(count), 1, " %"});
  };
  addRow(rows, "Scans read", std::to_string(run.scans.size() + run.droppedCount()));
  addRow(rows, "Dropped", droppedText(run));
  addRow(rows, "Inserted into the map", std::to_string(match.inserted));
  addRow(rows, "Searched exhaustively", std::to_string(match.searched));
  addRow(rows, "Match state",
         share(match.ok) + " ok, " + share(match.degraded) + " degraded, " + share(match.lost) +
             " lost");
  addRow(rows, "Match quality",
         text({match.mean_score, 3, " mean, "}) + text({match.min_score, 3, " min"}));
}

std::string mapText(const MapSnapshot& map) {
  return text({map.width * map.resolution_m, 1, " × "}) +
         text({map.height * map.resolution_m, 1, " m, "}) +
         text({knownArea(map), 0, " m² known, cell size "}) +
         text({map.resolution_m, kMillimeter, " m"});
}

/// The main numbers at the top of the page: [value, label].
Json headlinesOf(const OfflineRun& run, const RunInfo& info) {
  Json headlines = Json::array();
  addRow(headlines, std::to_string(run.scans.size()), "scans");
  addRow(headlines, text({run.distance_m, 1, " m"}), "traveled");
  addRow(headlines, text({run.duration_s, 0, " s"}), "recorded");
  if (info.timing) {
    addRow(headlines, text({scanTimes(run).mean, 2, " ms"}), "per scan");
    addRow(headlines, text({run.speedFactor(), 0, " ×"}), "real time");
    addRow(headlines, text({run.peak_memory_mb, 0, " MB"}), "peak memory");
  }
  return headlines;
}

std::string loopsOf(const GraphResult& graph) {
  std::string result;
  for (const auto& [what, count] : graph.counts())
    result += (result.empty() ? "" : ", ") + std::to_string(count) + " " + what;
  return result.empty() ? "none" : result;
}

/// Mean time of every part of the work.
std::string stagesText(const OfflineRun& run) {
  std::string result;
  for (std::size_t i = 0; i < kPipelineStages; ++i) {
    const auto stage = static_cast<PipelineStage>(i);
    result += (result.empty() ? "" : ", ") + std::string(toString(stage)) + " " +
              text({stageTimes(run, stage).mean, kMillimeter, " ms"});
  }
  return result;
}

Json rowsOf(const OfflineRun& run, const RunInfo& info) {
  Json rows = Json::array();
  addMatchRows(rows, run);
  addRow(rows, "Map", mapText(run.map));
  if (run.graph) addRow(rows, "Loops", loopsOf(*run.graph));
  addRow(rows, "Odometry", info.odometry ? "used" : "not used (laser only)");
  if (info.timing) {
    const Distribution ms = scanTimes(run);
    addRow(rows, "Time per scan",
           text({ms.median, 2, " ms median, "}) + text({ms.p99, 2, " ms p99, "}) +
               text({ms.max, 1, " ms max"}));
    addRow(rows, "Its parts, mean", stagesText(run));
  }
  return rows;
}

Json parameterRows(SlamConfig config) {
  SlamConfig defaults;
  const std::vector<Parameter> standard = parametersOf(defaults);
  const std::vector<Parameter> used = parametersOf(config);
  Json rows = Json::array();
  for (std::size_t i = 0; i < used.size(); ++i) {
    rows.push_back({{"name", used[i].name},
                    {"value", valueText(used[i])},
                    {"standard", valueText(standard[i])},
                    {"unit", used[i].unit},
                    {"description", used[i].description}});
  }
  return rows;
}

/// The time axis of all charts: seconds since the first scan.
std::vector<double> timesOf(const OfflineRun& run) {
  std::vector<double> times;
  for (const ScanRecord& scan : run.scans) times.push_back(scan.time - run.scans.front().time);
  return times;
}

Json chartOf(const char* title, const char* unit, const std::vector<double>& times,
             const std::vector<double>& values, int decimals) {
  Json t = Json::array(), v = Json::array();
  for (const std::size_t i : minMaxIndices(values, kMaxPoints)) {
    t.push_back(rounded(times[i], kMillimeter));
    v.push_back(rounded(values[i], decimals));
  }
  return {{"title", title}, {"unit", unit}, {"t", t}, {"v", v}};
}

/// A chart of shares, with an axis that does not depend on the values.
Json shareChartOf(const char* title, const std::vector<double>& times,
                  const std::vector<double>& values, double high) {
  Json chart = chartOf(title, "", times, values, 4);
  chart["high"] = high;
  return chart;
}

/// The curves of the pose filter, if it ran.
void addFilterCharts(const OfflineRun& run, const std::vector<double>& times, Json& charts) {
  std::vector<double> t, height, tilt, gyro, accelerometer;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const std::optional<FilterSample>& sample = run.scans[i].filter;
    if (!sample) continue;
    t.push_back(times[i]);
    height.push_back(sample->height_m);
    tilt.push_back(radToDeg(sample->tilt_rad));
    gyro.push_back(sample->gyro_bias_rad_s);
    accelerometer.push_back(sample->accelerometer_bias_m_s2);
  }
  if (t.empty()) return;
  charts.push_back(chartOf("Filter: height", "m", t, height, 3));
  charts.push_back(chartOf("Filter: tilt", "°", t, tilt, 2));
  charts.push_back(chartOf("Filter: bias of the gyro", "rad/s", t, gyro, 5));
  charts.push_back(chartOf("Filter: bias of the accelerometer", "m/s²", t, accelerometer, 4));
}

/// The curves of the tracker, if it kept out what moves.
void addTrackerCharts(const OfflineRun& run, const std::vector<double>& times, Json& charts) {
  std::vector<double> t, objects, beams;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const std::optional<TrackerSample>& sample = run.scans[i].tracker;
    if (!sample) continue;
    t.push_back(times[i]);
    objects.push_back(sample->objects);
    beams.push_back(sample->kept_out);
  }
  if (t.empty()) return;
  charts.push_back(chartOf("Tracker: moving objects", "", t, objects, 0));
  charts.push_back(shareChartOf("Tracker: share of the beams that are on them", t, beams, 1.0));
}

Json chartsOf(const OfflineRun& run, const RunInfo& info, const std::vector<double>& times) {
  std::vector<double> score, known, constraint, ms;
  std::vector<Pose2> poses;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    score.push_back(run.scans[i].score);
    known.push_back(run.scans[i].known);
    constraint.push_back(run.scans[i].constraint);
    ms.push_back(run.scans[i].ms);
    poses.push_back(run.trajectory[i].pose);
  }
  const Speeds speeds = speedsOf(times, poses);
  constexpr double kMostConstraint = 0.5;  // as many points for each of two directions
  Json charts =
      Json::array({shareChartOf("Match quality", times, score, 1.0),
                   shareChartOf("Overlap: share of the beams in known space", times, known, 1.0),
                   shareChartOf("Constraint: share of the points that show the weakest direction",
                                times, constraint, kMostConstraint)});
  if (info.timing) charts.push_back(chartOf("Time per scan", "ms", times, ms, 3));
  charts.push_back(chartOf("Speed", "m/s", times, speeds.linear_m_s, 3));
  charts.push_back(chartOf("Yaw rate", "rad/s", times, speeds.angular_rad_s, 3));
  addFilterCharts(run, times, charts);
  addTrackerCharts(run, times, charts);
  return charts;
}

/// How often each reason of a state was given, and the time of the first scan with it.
Json reasonsOf(const OfflineRun& run, const std::vector<double>& times) {
  std::map<std::pair<MatchState, std::string>, std::vector<double>> found;
  for (std::size_t i = 0; i < run.scans.size(); ++i)
    found[{run.scans[i].state, run.scans[i].reason}].push_back(times[i]);
  Json reasons = Json::array();
  for (const auto& [key, seen] : found) {
    reasons.push_back({{"state", toString(key.first)},
                       {"reason", key.second},
                       {"scans", seen.size()},
                       {"first", rounded(seen.front(), kMillimeter)}});
  }
  return reasons;
}

/// Every k-th pose, and also every pose at which the match state changes.
Json pathOf(const OfflineRun& run, const std::vector<double>& times) {
  Json t = Json::array(), x = Json::array(), y = Json::array(), yaw = Json::array(),
       state = Json::array(), reason = Json::array();
  const std::size_t stride = run.scans.size() / kMaxPoints + 1;
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const bool changes = i > 0 && run.scans[i].state != run.scans[i - 1].state;
    if (i % stride != 0 && !changes && i + 1 < run.scans.size()) continue;
    const Pose2& pose = run.trajectory[i].pose;
    t.push_back(rounded(times[i], kMillimeter));
    x.push_back(rounded(pose.x, kMillimeter));
    y.push_back(rounded(pose.y, kMillimeter));
    yaw.push_back(rounded(pose.yaw, kMillimeter));
    state.push_back(static_cast<int>(run.scans[i].state));
    reason.push_back(run.scans[i].reason);
  }
  return {{"t", t}, {"x", x}, {"y", y}, {"yaw", yaw}, {"state", state}, {"reason", reason}};
}

/// Where loops were accepted and refused: lines [x0, y0, x1, y1] (m) between the two keyframes,
/// with the reason ("" if accepted); and the path before the correction.
Json graphOf(const OfflineRun& run) {
  Json loops = Json::array(), x = Json::array(), y = Json::array();
  if (!run.graph) return {{"loops", loops}, {"x", x}, {"y", y}};
  const auto& vertices = run.graph->graph.vertices;
  for (const Loop& loop : run.graph->loops) {
    const Pose2 &a = vertices[loop.anchor].pose, &b = vertices[loop.query].pose;
    loops.push_back({{"at", Json::array({rounded(a.x, kMillimeter), rounded(a.y, kMillimeter),
                                         rounded(b.x, kMillimeter), rounded(b.y, kMillimeter)})},
                     {"state", toString(loop.state)},
                     {"reason", loop.reason}});
  }
  const std::size_t stride = run.graph->before.size() / kMaxPoints + 1;
  for (std::size_t i = 0; i < run.graph->before.size(); i += stride) {
    x.push_back(rounded(run.graph->before[i].pose.x, kMillimeter));
    y.push_back(rounded(run.graph->before[i].pose.y, kMillimeter));
  }
  return {{"loops", loops}, {"x", x}, {"y", y}};
}

/// The box around the walls: [x0, y0, x1, y1], m; null without walls.
Json wallsOf(const MapSnapshot& map) {
  const std::optional<Eigen::AlignedBox2d> box = wallBox(map);
  if (!box) return nullptr;
  return Json::array({box->min().x(), box->min().y(), box->max().x(), box->max().y()});
}

/// The picture, and the walls, on which the page opens.
Json mapOf(const MapSnapshot& map) {
  Json result = {{"walls", wallsOf(map)}};
  result.update(imageOf(map));
  return result;
}

}  // namespace

std::string reportHtml(const OfflineRun& run, const RunInfo& info) {
  const std::vector<double> times = timesOf(run);
  const Json data = {{"title", info.recording},
                     {"description", info.description},
                     {"version", kVersion},
                     {"headlines", headlinesOf(run, info)},
                     {"rows", rowsOf(run, info)},
                     {"warnings", run.warnings},
                     {"parameters", parameterRows(info.config)},
                     {"charts", chartsOf(run, info, times)},
                     {"reasons", reasonsOf(run, times)},
                     {"path", pathOf(run, times)},
                     {"graph", graphOf(run)},
                     {"map", mapOf(run.map)}};
  return std::string("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n") +
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n" +
         "<title>Mapping report</title>\n<style>" + kStyle + "</style>\n</head>\n" + kBody +
         "<script type=\"application/json\" id=\"data\">" + embedded(data) + "</script>\n<script>" +
         kMapScript + kPageScript + "</script>\n</body>\n</html>\n";
}

}  // namespace kestrel
