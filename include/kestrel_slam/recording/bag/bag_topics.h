// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/message_traits.h>

#include <cstddef>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace kestrel {

/// Properties of one topic of a bag.
struct BagTopic {
  std::string type, md5;
  std::size_t messages = 0;
};
using BagTopics = std::map<std::string, BagTopic>;

/// Lists the topics of a type as "a (5 messages), b (3 messages)". If `type` is empty, lists all
/// topics with their types.
std::string listTopics(const BagTopics& topics, const std::string& type);
/// The same for several types.
std::string listTopics(const BagTopics& topics, const std::vector<std::string>& types);

/// The topic of a type with the most messages; "" if there is none.
std::string busiestTopic(const BagTopics& topics, const std::string& type);

std::size_t countOfType(const BagTopics& topics, const std::string& type);

/// The topic that the user asked for; its leading slash is optional. If the bag does not have it,
/// throws std::runtime_error with a list of the topics of this type.
std::string requireTopic(const BagTopics& topics, const std::string& wanted,
                         const std::string& type);

std::string requireTopic(const BagTopics& topics, const std::string& wanted,
                         const std::vector<std::string>& types);

/// Throws std::runtime_error if the topic was recorded with another definition of its message.
void requireMd5(const BagTopics& topics, const std::string& name, const std::string& expected);

template <typename Message>
void requireVersion(const BagTopics& topics, const std::string& name) {
  requireMd5(topics, name, ros::message_traits::MD5Sum<Message>::value());
}

}  // namespace kestrel
