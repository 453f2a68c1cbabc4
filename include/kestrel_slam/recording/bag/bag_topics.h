// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/message_traits.h>
#include <rosbag/bag.h>

#include <cstddef>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace kestrel {

/// Opens a bag for reading. Throws std::runtime_error that names it where it is damaged or has no
/// index.
void openBag(rosbag::Bag& bag, const std::string& path);

/// What a bag says of one of its topics.
struct BagTopic {
  std::string type, md5;
  std::size_t messages = 0;
};
using BagTopics = std::map<std::string, BagTopic>;

BagTopics topicsOf(const rosbag::Bag& bag);

/// "a (5 messages), b (3 messages)" for the topics of a type; of all topics, with their types,
/// where `type` is empty.
std::string listTopics(const BagTopics& topics, const std::string& type);
/// The same for several types.
std::string listTopics(const BagTopics& topics, const std::vector<std::string>& types);

/// The topic with the most messages of a type; "" where no topic has any.
std::string busiestTopic(const BagTopics& topics, const std::string& type);

std::size_t countOfType(const BagTopics& topics, const std::string& type);

/// The topic that the user asked for, with or without its leading slash. Throws std::runtime_error
/// that lists the topics of this type.
std::string requireTopic(const BagTopics& topics, const std::string& wanted,
                         const std::string& type);

std::string requireTopic(const BagTopics& topics, const std::string& wanted,
                         const std::vector<std::string>& types);

/// Throws std::runtime_error where the topic was recorded with another definition of its message.
void requireMd5(const BagTopics& topics, const std::string& name, const std::string& expected);

template <typename Message>
void requireVersion(const BagTopics& topics, const std::string& name) {
  requireMd5(topics, name, ros::message_traits::MD5Sum<Message>::value());
}

}  // namespace kestrel
