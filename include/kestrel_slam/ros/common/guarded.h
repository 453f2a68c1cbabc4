// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/message_traits.h>
#include <ros/node_handle.h>

#include <boost/function.hpp>
#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <string>

#include "kestrel_slam/ros/common/stamps.h"

namespace kestrel {

/// Logs an exception that a callback has thrown. Throttled.
void reportException(const std::string& where, const char* what) noexcept;

/// Runs the code of a callback. No exception may leave a callback: it would end the node, or the
/// nodelet manager with everything in it.
template <typename Code>
void guarded(const std::string& where, const Code& code) noexcept {
  try {
    code();
  } catch (const std::exception& error) {
    reportException(where, error.what());
  } catch (...) {
    reportException(where, "unknown exception");
  }
}

/// Receives the reason why a message is refused.
using Refuse = std::function<void(const std::string& reason)>;

/// Logs the reason. Throttled.
void logRefusal(const std::string& topic, const std::string& reason);

/// What happens to the stamps of a topic. Poses that a user sets may have any stamp.
enum class Stamps { kChecked, kIgnored };

/// How a node subscribes to every topic: `callback` gets only messages with a plausible stamp, and
/// its exceptions do not leave it. `refuse` is called for the other messages; without it, they are
/// logged.
template <typename Message>
ros::Subscriber subscribeGuarded(
    ros::NodeHandle nh, const std::string& topic, std::uint32_t queue,
    std::function<void(const boost::shared_ptr<const Message>&)> callback, Refuse refuse = {},
    Stamps stamps = Stamps::kChecked) {
  const std::string name = nh.resolveName(topic);
  if (!refuse) refuse = [name](const std::string& reason) { logRefusal(name, reason); };
  const auto gate = std::make_shared<StampGate>();
  const auto receive = [=](const boost::shared_ptr<const Message>& message) {
    if constexpr (ros::message_traits::HasHeader<Message>::value) {
      if (stamps == Stamps::kChecked) {
        const std::string reason = gate->refusal(message->header.stamp, ros::Time::now());
        if (!reason.empty()) return refuse(reason);
      }
    }
    callback(message);
  };
  const boost::function<void(const boost::shared_ptr<const Message>&)> on_message =
      [=](const boost::shared_ptr<const Message>& message) {
        guarded(name, [&] { receive(message); });
      };
  return nh.subscribe<Message>(topic, queue, on_message, ros::VoidConstPtr(),
                               ros::TransportHints().tcpNoDelay());
}

}  // namespace kestrel
