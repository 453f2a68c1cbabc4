// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_people.h"

#include <sensor_msgs/LaserScan.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#include "kestrel_slam/recording/bag/bag_files.h"
#include "kestrel_slam/recording/bag/bag_topics.h"

namespace kestrel {
namespace {

const std::string kType = "leg_tracker/Person";

// geometry_msgs/Pose pose, uint32 id: seven doubles and a number, without padding. The package of
// the message is not needed to read it.
constexpr std::size_t kPoseNumbers = 7;
constexpr std::size_t kBytes = kPoseNumbers * sizeof(double) + sizeof(std::uint32_t);

TrueObject personOf(const rosbag::MessageInstance& message) {
  if (message.size() != kBytes) throw std::runtime_error("has another definition of Person");
  std::vector<std::uint8_t> bytes(kBytes);
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  message.write(stream);
  double numbers[kPoseNumbers];
  std::uint32_t id = 0;
  std::memcpy(numbers, bytes.data(), sizeof(numbers));
  std::memcpy(&id, bytes.data() + sizeof(numbers), sizeof(id));
  return {message.getTime().toSec(), static_cast<long>(id), {numbers[0], numbers[1]}};
}

struct MarkedScan {
  double recorded, stamp;  ///< s
};

/// The scans of the busiest laser.
std::vector<MarkedScan> scansOf(const BagFiles& files, const BagTopics& topics) {
  std::vector<MarkedScan> scans;
  const std::string topic =
      busiestTopic(topics, ros::message_traits::datatype<sensor_msgs::LaserScan>());
  if (topic.empty()) return scans;
  files.forEach(topic, [&](const rosbag::MessageInstance& message) {
    const auto scan = message.instantiate<sensor_msgs::LaserScan>();
    if (scan) scans.push_back({message.getTime().toSec(), scan->header.stamp.toSec()});
  });
  return scans;
}

/// A mark is recorded between the scan that it belongs to and the next one. Without scans: the time
/// of recording.
double stampOf(double recorded, const std::vector<MarkedScan>& scans) {
  const auto next =
      std::upper_bound(scans.begin(), scans.end(), recorded,
                       [](double time, const MarkedScan& scan) { return time < scan.recorded; });
  return next == scans.begin() ? recorded : std::prev(next)->stamp;
}

}  // namespace

std::vector<TrueObject> readBagPeople(const std::string& path, const std::string& topic) {
  const BagFiles files({path});
  const BagTopics topics = files.topics();
  const std::string chosen =
      topic.empty() ? busiestTopic(topics, kType) : requireTopic(topics, topic, kType);
  if (chosen.empty()) {
    throw std::runtime_error(path + ": has no topic of type " + kType +
                             "; its topics: " + listTopics(topics, ""));
  }
  const std::vector<MarkedScan> scans = scansOf(files, topics);
  std::vector<TrueObject> people;
  files.forEach(chosen, [&](const rosbag::MessageInstance& message) {
    TrueObject person = personOf(message);
    person.stamp = stampOf(person.stamp, scans);
    if (person.position.allFinite()) people.push_back(person);
  });
  return people;
}

}  // namespace kestrel
