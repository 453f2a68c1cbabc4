// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/filter_input.h"

#include <utility>

#include "kestrel_slam/messages/pipeline_messages.h"
#include "kestrel_slam/ros/common/guarded.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 400;

}  // namespace

FilterInput::FilterInput(ros::NodeHandle nh, const ProjectorNodeConfig& config,
                         ProjectionStage& projection,
                         std::function<void(const ros::Time&)> on_state)
    : projection_(projection), on_state_(std::move(on_state)) {
  if (config.filter_topic.empty() || !config.usesImu()) return;
  subscriber_ = subscribeGuarded<kestrel_slam::FilteredMotion>(
      nh, config.filter_topic, kQueue,
      [this](const kestrel_slam::FilteredMotionConstPtr& message) { onMotion(message); });
}

void FilterInput::onMotion(const kestrel_slam::FilteredMotionConstPtr& message) {
  if (projection_.addMotion(fromMessage(*message))) on_state_(message->header.stamp);
}

}  // namespace kestrel
