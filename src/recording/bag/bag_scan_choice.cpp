// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/recording/bag/bag_scans.h"

namespace kestrel {
namespace {

/// How much a scanner sees.
struct View {
  double field_of_view = 0.0;  ///< rad
  double beams = 0.0;
  double range = 0.0;  ///< m
  double level = 1.0;  ///< cosine between the axis of the laser and the vertical of the vehicle

  double size() const { return field_of_view * beams * range * level; }
};

struct Candidate {
  ScanTopic topic;
  View view;
  double scans = 0.0;  ///< on the topic
};

View viewOf(const LaserScan& scan) {
  View view;
  view.beams = static_cast<double>(scan.ranges.size());
  view.field_of_view =
      std::min(2.0 * kPi, std::abs(scan.angle_increment) * std::max(0.0, view.beams - 1.0));
  // Some drivers do not fill range_max, or with a number that no laser reaches.
  constexpr double kLongestRange = 300.0;
  view.range = scan.range_max > 0.0 && scan.range_max < kLongestRange ? scan.range_max : 0.0;
  if (view.range > 0.0) return view;
  for (const float range : scan.ranges) {
    if (std::isfinite(range)) view.range = std::max(view.range, static_cast<double>(range));
  }
  return view;
}

View viewOf(const PointCloud& cloud) {
  View view;
  view.field_of_view = azimuthArc(cloud).length;
  for (const PointCloud::Point& point : cloud.points) {
    const double range = std::hypot(point.x, point.y);
    if (!std::isfinite(range) || range == 0.0) continue;
    view.beams += 1.0;
    view.range = std::max(view.range, range);
  }
  return view;
}

double levelOf(const BagTransforms& transforms, const std::string& frame) {
  const auto base_T_laser = transforms.lookup(transforms.vehicleFrame(frame), frame, ros::Time());
  return base_T_laser ? std::abs(base_T_laser->linear()(2, 2)) : 1.0;
}

/// Reads the first scans on the topic.
Candidate examine(const BagFiles& files, const std::string& name, bool clouds,
                  const BagTransforms& transforms) {
  constexpr std::size_t kEnoughScans = 5, kEnoughMessages = 500;
  Candidate candidate;
  candidate.topic.name = name;
  candidate.topic.clouds = clouds;
  BagScans scans(files, name);
  BagScan scan;
  std::size_t count = 0;
  for (; count < kEnoughScans && scans.messagesRead() < kEnoughMessages && scans.next(scan);
       ++count) {
    View view = scan.cloud ? viewOf(*scan.cloud) : viewOf(scan.scan);
    if (!scan.cloud) view.level = levelOf(transforms, scan.frame);
    if (view.size() >= candidate.view.size()) candidate.view = view;
    if (count > 0) continue;
    candidate.topic.frame = scan.frame;
    candidate.topic.clock_offset = scan.scan.stamp - scan.recorded;
  }
  if (scans.joins() && count > 0) {
    candidate.topic.messages_per_scan = std::max(
        1.0, std::round(static_cast<double>(scans.messagesRead()) / static_cast<double>(count)));
  }
  return candidate;
}

std::string textOf(const View& view) {
  std::ostringstream text;
  text << std::lround(radToDeg(view.field_of_view)) << " deg, " << view.beams << " beams, "
       << std::lround(view.range) << " m";
  return text.str();
}

/// The topics of these types that can be read, those that see most first.
std::vector<Candidate> rank(const BagFiles& files, const BagTopics& topics, bool clouds,
                            const BagTransforms& transforms) {
  std::vector<Candidate> candidates;
  for (const std::string& type : clouds ? cloudTypes() : scanTypes()) {
    for (const auto& [name, topic] : topics) {
      if (topic.type != type || topic.messages == 0) continue;
      candidates.push_back(examine(files, name, clouds, transforms));
      Candidate& candidate = candidates.back();
      candidate.scans = static_cast<double>(topic.messages) / candidate.topic.messages_per_scan;
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return std::pair(a.view.size(), a.scans) > std::pair(b.view.size(), b.scans);
  });
  return candidates;
}

std::string listOf(const std::vector<Candidate>& candidates) {
  std::string text;
  for (const Candidate& candidate : candidates) {
    text += (text.empty() ? "" : "; ") + candidate.topic.name + " (" + textOf(candidate.view) + ")";
  }
  return text;
}

std::vector<std::string> allTypes() {
  std::vector<std::string> types = scanTypes();
  types.insert(types.end(), cloudTypes().begin(), cloudTypes().end());
  return types;
}

/// What to do with messages from which scans can be made.
std::string adviceFor(const BagTopics& topics) {
  static const std::pair<const char*, const char*> kAdvice[] = {
      {"livox_ros_driver/CustomMsg", "record with xfer_format 0 (PointCloud2) of the Livox driver"},
      {"livox_ros_driver2/CustomMsg",
       "record with xfer_format 0 (PointCloud2) of the Livox driver"},
      {"velodyne_msgs/VelodyneScan",
       "record the clouds of velodyne_pointcloud while it is replayed"},
      {"ouster_ros/PacketMsg", "record the clouds of ouster_ros while it is replayed"},
      {"sensor_msgs/Image", "from depth images, record the scans of depthimage_to_laserscan"}};
  for (const auto& [type, advice] : kAdvice) {
    if (countOfType(topics, type) > 0) return std::string("; ") + type + ": " + advice;
  }
  return "";
}

[[noreturn]] void failWithoutTopic(const BagTopics& topics) {
  std::string types;
  for (const std::string& type : allTypes()) {
    types += (types.empty() ? "has no " : " and no ") + type;
  }
  throw std::runtime_error(types + " messages, so there is nothing to map" + adviceFor(topics) +
                           "; its topics: " + listTopics(topics, ""));
}

ScanTopic wantedTopic(const BagFiles& files, const BagTopics& topics,
                      const BagTransforms& transforms, const std::string& wanted) {
  const std::string name = requireTopic(topics, wanted, allTypes());
  const std::string& type = topics.at(name).type;
  requireMd5(topics, name, md5OfScanType(type));
  const auto& clouds = cloudTypes();
  return examine(files, name, std::find(clouds.begin(), clouds.end(), type) != clouds.end(),
                 transforms)
      .topic;
}

}  // namespace

ScanTopic chooseScanTopic(const BagFiles& files, const BagTopics& topics,
                          const BagTransforms& transforms, const RecordingOptions& options,
                          std::vector<std::string>& warnings) {
  if (!options.scan_topic.empty()) {
    return wantedTopic(files, topics, transforms, options.scan_topic);
  }
  std::vector<Candidate> candidates = rank(files, topics, options.prefer_clouds, transforms);
  if (candidates.empty() || candidates.front().view.size() == 0.0) {
    std::vector<Candidate> others = rank(files, topics, !options.prefer_clouds, transforms);
    const bool better = !others.empty() && others.front().view.size() > 0.0;
    if (better || candidates.empty()) candidates = std::move(others);
  }
  if (candidates.empty()) failWithoutTopic(topics);
  const ScanTopic& best = candidates.front().topic;
  requireMd5(topics, best.name, md5OfScanType(topics.at(best.name).type));
  if (candidates.size() > 1) {
    warnings.push_back(std::string("there are several ") + (best.clouds ? "cloud" : "laser") +
                       " topics; the one that sees most is used: " + best.name +
                       "; topics: " + listOf(candidates));
  }
  return best;
}

}  // namespace kestrel
