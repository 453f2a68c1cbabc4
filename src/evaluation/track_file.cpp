// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/track_file.h"

#include <cmath>
#include <iomanip>
#include <istream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/recording/text_stream.h"

namespace kestrel {
namespace {

constexpr const char* kHeader =
    "stamp,id,state,moved,size,x,y,vx,vy,sigma_x,sigma_y,sigma_vx,sigma_vy,turn_rate,standing,"
    "box_x,box_y,box_yaw,length,width,age,unseen,shown";
constexpr int kTrackStampDecimals = 6, kDecimals = 4;
constexpr int kJsonIndent = 1;
constexpr double kMillimeters = 1e3;

double rounded(double value) { return std::round(value * kMillimeters) / kMillimeters; }

void write(std::ostream& out, double stamp, const Track& t) {
  const Eigen::Vector4d sigmas = t.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  out << std::fixed << std::setprecision(kTrackStampDecimals) << stamp
      << std::setprecision(kDecimals) << ',' << t.id << ',' << toString(t.state) << ',' << t.moved
      << ',' << toString(t.size) << ',' << t.position.x() << ',' << t.position.y() << ','
      << t.velocity.x() << ',' << t.velocity.y();
  for (int i = 0; i < sigmas.size(); ++i) out << ',' << sigmas(i);
  out << ',' << t.turn_rate << ',' << t.standing << ',' << t.box.center.x() << ','
      << t.box.center.y() << ',' << t.box.yaw << ',' << t.box.size.x() << ',' << t.box.size.y()
      << ',' << t.age_s << ',' << t.unseen_s << ',' << t.isShown() << '\n';
}

TrackRow rowOf(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> fields;
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  constexpr std::size_t kTrackFields = 23;
  if (fields.size() != kTrackFields) {
    throw std::runtime_error("expected " + std::to_string(kTrackFields) + " fields, found " +
                             std::to_string(fields.size()));
  }
  TrackRow row;
  try {
    row.stamp = std::stod(fields[0]);
    row.id = std::stol(fields[1]);
    row.shown = fields[22] == "1";
    row.tentative = fields[2] == toString(TrackState::kTentative);
    row.moved = fields[3] == "1";
    row.position = {std::stod(fields[5]), std::stod(fields[6])};
    row.velocity = {std::stod(fields[7]), std::stod(fields[8])};
  } catch (const std::logic_error&) {
    throw std::runtime_error("a field is not a number");
  }
  return row;
}

}  // namespace

std::string tracksCsv(const std::vector<TrackFrame>& frames) {
  std::ostringstream out;
  out << kHeader << '\n';
  for (const TrackFrame& frame : frames) {
    for (const Track& track : frame.tracks) write(out, frame.stamp, track);
  }
  return out.str();
}

std::string tracksJson(const std::vector<TrackFrame>& frames) {
  std::map<long, nlohmann::ordered_json> tracks;
  std::size_t saturated = 0;
  for (const TrackFrame& frame : frames) {
    if (frame.saturated) ++saturated;
    for (const Track& track : frame.tracks) {
      if (!track.isShown()) continue;
      nlohmann::ordered_json& json = tracks[track.id];
      json["id"] = track.id;
      json["size"] = toString(track.size);
      json["path"].push_back({frame.stamp, rounded(track.position.x()), rounded(track.position.y()),
                              rounded(track.velocity.x()), rounded(track.velocity.y())});
    }
  }
  nlohmann::ordered_json json = {{"scans", frames.size()},
                                 {"saturated_scans", saturated},
                                 {"path_columns", {"stamp", "x", "y", "vx", "vy"}},
                                 {"tracks", nlohmann::ordered_json::array()}};
  for (auto& [id, track] : tracks) json["tracks"].push_back(std::move(track));
  return json.dump(kJsonIndent) + "\n";
}

std::vector<TrackRow> readTracks(const std::string& path) {
  const std::unique_ptr<std::istream> stream = openText(path);
  std::vector<TrackRow> rows;
  std::string line;
  std::size_t number = 0;
  while (readLine(*stream, line)) {
    ++number;
    try {
      if (number == 1 && line != kHeader)
        throw std::runtime_error("has not the header of tracks.csv");
      if (number > 1) rows.push_back(rowOf(line));
    } catch (const std::exception& error) {
      throw std::runtime_error(path + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  return rows;
}

}  // namespace kestrel
