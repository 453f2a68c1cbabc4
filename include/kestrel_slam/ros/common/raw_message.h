// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace kestrel {

/// A received message of any type, not yet deserialized.
struct RawMessage {
  std::string type, md5;
  std::vector<std::uint8_t> bytes;

  /// Throws std::exception if the message has another type, or if its bytes are damaged.
  template <typename Message>
  Message as() const {
    if (md5 != ros::message_traits::MD5Sum<Message>::value()) {
      throw std::invalid_argument("it has another version of " + type);
    }
    std::vector<std::uint8_t> copy = bytes;
    ros::serialization::IStream in(copy.data(), static_cast<std::uint32_t>(copy.size()));
    Message message;
    ros::serialization::deserialize(in, message);
    return message;
  }
};

}  // namespace kestrel

namespace ros::message_traits {

template <>
struct IsMessage<kestrel::RawMessage> : TrueType {};
template <>
struct IsMessage<const kestrel::RawMessage> : TrueType {};

/// "*" lets roscpp subscribe to messages of any type.
template <>
struct MD5Sum<kestrel::RawMessage> {
  static const char* value() { return "*"; }
  static const char* value(const kestrel::RawMessage& /*message*/) { return value(); }
};
template <>
struct DataType<kestrel::RawMessage> {
  static const char* value() { return "*"; }
  static const char* value(const kestrel::RawMessage& /*message*/) { return value(); }
};

}  // namespace ros::message_traits

namespace ros::serialization {

template <>
struct Serializer<kestrel::RawMessage> {
  template <typename Stream>
  static void read(Stream& stream, kestrel::RawMessage& message) {
    const std::uint32_t size = stream.getLength();
    message.bytes.resize(size);
    if (size > 0) std::memcpy(message.bytes.data(), stream.advance(size), size);
  }
};

template <>
struct PreDeserialize<kestrel::RawMessage> {
  static void notify(const PreDeserializeParams<kestrel::RawMessage>& params) {
    params.message->type = (*params.connection_header)["type"];
    params.message->md5 = (*params.connection_header)["md5sum"];
  }
};

}  // namespace ros::serialization
