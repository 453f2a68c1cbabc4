// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/tracks_page.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "page_data.h"

namespace kestrel {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kPage =
#include "page/tracks.html.inc"
    ;
constexpr const char* kScript =
#include "page/tracks.js.inc"
    ;
constexpr double kStampTolerance = 1e-5;  // s

double rounded(double value) {
  constexpr double kThousand = 1000.0;
  return std::round(kThousand * value) / kThousand;
}

/// Transform from the frame of the tracks into the map at each scan. A scan that the path in the
/// map does not have gets that of the scan before.
std::vector<Pose2> mapFromOdom(const TracksPage& page) {
  std::vector<Pose2> result;
  auto at = page.map_path.begin();
  for (const StampedPose& odom : page.odom_path) {
    at = std::find_if(at, page.map_path.end(), [&](const StampedPose& pose) {
      return pose.stamp >= odom.stamp - kStampTolerance;
    });
    if (at == page.map_path.end()) break;
    result.push_back(at->pose * odom.pose.inverse());
  }
  result.resize(page.odom_path.size(), result.empty() ? Pose2() : result.back());
  return result;
}

Json vehicleOf(const TracksPage& page, const std::vector<Pose2>& map_T_odom) {
  Json t = Json::array(), x = Json::array(), y = Json::array();
  for (std::size_t i = 0; i < page.odom_path.size(); ++i) {
    const Pose2 pose = map_T_odom[i] * page.odom_path[i].pose;
    t.push_back(rounded(page.odom_path[i].stamp - page.odom_path.front().stamp));
    x.push_back(rounded(pose.x));
    y.push_back(rounded(pose.y));
  }
  return {{"t", t}, {"x", x}, {"y", y}};
}

void addPoint(const Track& track, const Pose2& map_T_odom, double time, Json& json) {
  const Eigen::Vector2d at = map_T_odom * track.position;
  json["id"] = track.id;
  json["size"] = toString(track.size);
  json["t"].push_back(rounded(time));
  json["x"].push_back(rounded(at.x()));
  json["y"].push_back(rounded(at.y()));
  json["v"].push_back(rounded(track.velocity.norm()));
}

Json tracksOf(const TracksPage& page, const std::vector<Pose2>& map_T_odom) {
  std::map<long, Json> by_id;
  for (std::size_t i = 0; i < page.frames.size() && i < map_T_odom.size(); ++i) {
    const double time = page.frames[i].stamp - page.odom_path.front().stamp;
    for (const Track& track : page.frames[i].tracks) {
      if (track.isShown()) addPoint(track, map_T_odom[i], time, by_id[track.id]);
    }
  }
  Json tracks = Json::array();
  for (auto& [id, track] : by_id) tracks.push_back(std::move(track));
  return tracks;
}

}  // namespace

std::string tracksHtml(const TracksPage& page) {
  const std::vector<Pose2> map_T_odom = mapFromOdom(page);
  const Json data = {{"title", page.title},
                     {"map", imageOf(page.map)},
                     {"vehicle", vehicleOf(page, map_T_odom)},
                     {"tracks", tracksOf(page, map_T_odom)}};
  return std::string(kPage) + "<script type=\"application/json\" id=\"data\">" + embedded(data) +
         "</script>\n<script>" + kScript + "</script>\n</body>\n</html>\n";
}

}  // namespace kestrel
