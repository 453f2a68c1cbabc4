// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_topics.h"

#include <algorithm>
#include <sstream>

#include "kestrel_slam/messages/sensor_messages.h"

namespace kestrel {
namespace {

bool contains(const std::vector<std::string>& items, const std::string& item) {
  return std::find(items.begin(), items.end(), item) != items.end();
}

}  // namespace

std::string listTopics(const BagTopics& topics, const std::string& type) {
  return listTopics(topics,
                    type.empty() ? std::vector<std::string>() : std::vector<std::string>{type});
}

std::string listTopics(const BagTopics& topics, const std::vector<std::string>& types) {
  std::ostringstream text;
  for (const auto& [name, topic] : topics) {
    if (!types.empty() && !contains(types, topic.type)) continue;
    text << (text.tellp() > 0 ? ", " : "") << name << " (";
    if (types.size() != 1) text << topic.type << ", ";
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
  return requireTopic(topics, wanted, std::vector<std::string>{type});
}

std::string requireTopic(const BagTopics& topics, const std::string& wanted,
                         const std::vector<std::string>& types) {
  for (const auto& [name, topic] : topics) {
    if (withoutSlash(name) == withoutSlash(wanted) && contains(types, topic.type)) return name;
  }
  std::string list;
  for (const std::string& type : types) list += (list.empty() ? "" : " or ") + type;
  throw std::runtime_error("no topic " + wanted + " of type " + list +
                           "; choose one of: " + listTopics(topics, types));
}

void requireMd5(const BagTopics& topics, const std::string& name, const std::string& expected) {
  const BagTopic& topic = topics.at(name);
  if (topic.md5 == expected) return;
  throw std::runtime_error("topic " + name + " has a different version of " + topic.type +
                           " (md5 " + topic.md5 + ", expected " + expected +
                           "); convert the bag with `rosbag fix`");
}

}  // namespace kestrel
