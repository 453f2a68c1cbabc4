// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/true_objects.h"

#include <algorithm>
#include <istream>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/recording/reference.h"
#include "kestrel_slam/recording/text_stream.h"
#ifdef KESTREL_WITH_ROS
#include "kestrel_slam/recording/bag/bag_people.h"
#endif

namespace kestrel {
namespace {

constexpr double kMaxGap = 0.1;  ///< s; between a pose of the object and one of the sensor

TrueObject objectOf(const std::string& line) {
  std::istringstream fields(line);
  TrueObject object;
  char comma = 0;
  double x = 0.0, y = 0.0;
  fields >> object.stamp >> comma >> object.id >> comma >> x >> comma >> y;
  if (!fields) throw std::runtime_error("expected stamp,id,x,y");
  object.position = {x, y};
  return object;
}

std::vector<TrueObject> readText(const std::string& path) {
  const std::unique_ptr<std::istream> stream = openText(path);
  std::vector<TrueObject> objects;
  std::string line;
  for (std::size_t number = 1; readLine(*stream, line); ++number) {
    if (number == 1 && line.rfind("stamp", 0) == 0) continue;
    try {
      objects.push_back(objectOf(line));
    } catch (const std::exception& error) {
      throw std::runtime_error(path + ":" + std::to_string(number) + ": " + error.what());
    }
  }
  return objects;
}

/// Poses of the object in the frame of the sensor.
std::vector<TrueObject> relativeTo(const Trajectory& sensor, const Trajectory& object, long id) {
  std::vector<TrueObject> objects;
  for (const StampedPose& pose : object) {
    const auto next =
        std::lower_bound(sensor.begin(), sensor.end(), pose.stamp,
                         [](const StampedPose& a, double stamp) { return a.stamp < stamp; });
    if (next == sensor.end()) break;
    const auto last = next == sensor.begin() ? next : std::prev(next);
    if (next->stamp - last->stamp > kMaxGap || pose.stamp < last->stamp) continue;
    const double span = next->stamp - last->stamp;
    const double share = span > 0.0 ? (pose.stamp - last->stamp) / span : 0.0;
    const Pose2 at = interpolate(last->pose, next->pose, share);
    objects.push_back({pose.stamp, id, at.inverse() * pose.pose.translation()});
  }
  return objects;
}

std::vector<TrueObject> readCaptured(const std::string& path,
                                     const std::vector<std::string>& topics,
                                     const std::string& sensor_topic) {
  if (topics.empty())
    throw std::runtime_error(path + ": a topic of the poses of an object is needed");
  const Trajectory sensor = readReference(path, sensor_topic);
  std::vector<TrueObject> objects;
  for (std::size_t i = 0; i < topics.size(); ++i) {
    const auto poses = relativeTo(sensor, readReference(path, topics[i]), static_cast<long>(i) + 1);
    objects.insert(objects.end(), poses.begin(), poses.end());
  }
  return objects;
}

std::vector<TrueObject> readPeople(const std::string& path,
                                   const std::vector<std::string>& topics) {
  if (topics.size() > 1) {
    throw std::runtime_error(path + ": several topics need one with the poses of the sensor");
  }
#ifdef KESTREL_WITH_ROS
  return readBagPeople(path, topics.empty() ? "" : topics.front());
#else
  throw std::runtime_error(path + ": this build has no ROS and cannot read a rosbag");
#endif
}

}  // namespace

std::vector<TrueObject> readTrueObjects(const std::string& path,
                                        const std::vector<std::string>& topics,
                                        const std::string& sensor_topic) {
  std::vector<TrueObject> objects;
  if (!isBag(path)) {
    objects = readText(path);
  } else if (!sensor_topic.empty()) {
    objects = readCaptured(path, topics, sensor_topic);
  } else {
    objects = readPeople(path, topics);
  }
  if (objects.empty()) throw std::runtime_error(path + ": has no true positions");
  std::stable_sort(objects.begin(), objects.end(),
                   [](const TrueObject& a, const TrueObject& b) { return a.stamp < b.stamp; });
  return objects;
}

}  // namespace kestrel
