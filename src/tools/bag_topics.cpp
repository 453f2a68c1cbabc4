#include "kestrel_slam/tools/bag_topics.h"

#include <rosbag/view.h>

#include <algorithm>
#include <sstream>

#include "kestrel_slam/tools/bag_transforms.h"

namespace kestrel_slam {

BagTopics topicsOf(const rosbag::Bag& bag) {
  BagTopics topics;
  rosbag::View all(bag);
  for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
    BagTopic& topic = topics[connection->topic];
    topic.type = connection->datatype;
    topic.md5 = connection->md5sum;
  }
  for (auto& [name, topic] : topics)
    topic.messages = rosbag::View(bag, rosbag::TopicQuery(name)).size();
  return topics;
}

std::string listTopics(const BagTopics& topics, const std::string& type) {
  std::ostringstream text;
  for (const auto& [name, topic] : topics) {
    if (!type.empty() && topic.type != type) continue;
    text << (text.tellp() > 0 ? ", " : "") << name << " (";
    if (type.empty()) text << topic.type << ", ";
    text << topic.messages << " messages)";
  }
  return text.tellp() > 0 ? text.str() : "none";
}

std::string busiestTopic(const BagTopics& topics, const std::string& type) {
  std::string best;
  std::size_t most = 0;
  for (const auto& [name, topic] : topics) {
    if (topic.type != type || topic.messages <= most) continue;
    best = name;
    most = topic.messages;
  }
  return best;
}

std::size_t countOfType(const BagTopics& topics, const std::string& type) {
  return static_cast<std::size_t>(std::count_if(
      topics.begin(), topics.end(), [&](const auto& entry) { return entry.second.type == type; }));
}

std::string requireTopic(const BagTopics& topics, const std::string& wanted,
                         const std::string& type) {
  for (const auto& [name, topic] : topics) {
    if (withoutSlash(name) == withoutSlash(wanted) && topic.type == type) return name;
  }
  throw std::runtime_error("no topic " + wanted + " of type " + type +
                           "; choose one of: " + listTopics(topics, type));
}

void requireMd5(const BagTopics& topics, const std::string& name, const std::string& expected) {
  const BagTopic& topic = topics.at(name);
  if (topic.md5 == expected) return;
  throw std::runtime_error("topic " + name + " has another version of " + topic.type + " (md5 " +
                           topic.md5 + ", expected " + expected +
                           "); convert the bag with `rosbag fix`");
}

}  // namespace kestrel_slam
