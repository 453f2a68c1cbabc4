// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_transforms.h"

#include <geometry_msgs/TransformStamped.h>
#include <tf2/exceptions.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/sensor_messages.h"

namespace kestrel {
namespace {

// Longer than any recording, so that the buffer never drops a transform.
const ros::Duration kKeepAll(30.0 * 24.0 * 3600.0);
constexpr double kRigidTolerance = 1e-6;  // m, and for elements of the rotation matrix

bool isUsable(const geometry_msgs::TransformStamped& transform) {
  constexpr double kNormTolerance = 1e-2;  // for the squared norm; tf2 rejects larger errors
  const auto& t = transform.transform.translation;
  const auto& q = transform.transform.rotation;
  const double norm2 = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  return std::isfinite(t.x + t.y + t.z) && std::abs(norm2 - 1.0) < kNormTolerance &&
         !transform.header.frame_id.empty() && !transform.child_frame_id.empty() &&
         transform.header.frame_id != transform.child_frame_id;
}

const std::string kBaseName = "base_link";

/// The name of a frame without its namespace.
std::string lastPart(const std::string& frame) { return frame.substr(frame.rfind('/') + 1); }

bool isBaseName(const std::string& frame) { return lastPart(frame) == kBaseName; }

}  // namespace

BagTransforms::BagTransforms(const BagFiles& files) : buffer_(kKeepAll) {
  const std::vector<std::string> names = {"/tf", "tf", "/tf_static", "tf_static"};
  const BagTopics topics = files.topics();
  for (const std::string& name : names) {
    if (topics.count(name) > 0) requireVersion<tf2_msgs::TFMessage>(topics, name);
  }
  bad_ += files.forEach(names, [this](const rosbag::MessageInstance& message) {
    const auto transforms = message.instantiate<tf2_msgs::TFMessage>();
    if (!transforms) throw std::runtime_error("another type on the topic of tf");
    const bool is_static = withoutSlash(message.getTopic()) == "tf_static";
    for (const auto& transform : transforms->transforms) add(transform, is_static);
  });
}

void BagTransforms::add(const geometry_msgs::TransformStamped& original, bool is_static) {
  geometry_msgs::TransformStamped transform = original;
  transform.header.frame_id = withoutSlash(original.header.frame_id);
  transform.child_frame_id = withoutSlash(original.child_frame_id);
  if (!isUsable(transform) || !buffer_.setTransform(transform, "bag", is_static)) {
    ++bad_;
    return;
  }
  if (!is_static && !first_stamp_) first_stamp_ = transform.header.stamp.toSec();
  const Eigen::Isometry3d value = fromMessage(transform.transform);
  Edge& edge = edges_.emplace(transform.child_frame_id, Edge{"", value}).first->second;
  const bool same = edge.first.matrix().isApprox(value.matrix(), kRigidTolerance) &&
                    (edge.parent.empty() || edge.parent == transform.header.frame_id);
  edge.rigid = edge.rigid && same;
  edge.parent = transform.header.frame_id;
}

bool BagTransforms::knows(const std::string& frame) const {
  return edges_.count(frame) > 0 ||
         std::any_of(edges_.begin(), edges_.end(),
                     [&](const auto& entry) { return entry.second.parent == frame; });
}

std::vector<std::string> BagTransforms::ancestors(const std::string& frame) const {
  std::vector<std::string> result;
  auto edge = edges_.find(frame);
  while (edge != edges_.end() &&
         result.size() <= edges_.size()) {  // also ends if frames form a loop
    result.push_back(edge->second.parent);
    edge = edges_.find(edge->second.parent);
  }
  return result;
}

std::string BagTransforms::vehicleFrame(const std::string& sensor_frame) const {
  const std::vector<std::string> above = ancestors(sensor_frame);
  if (above.empty()) return !knows(sensor_frame) && knows(kBaseName) ? kBaseName : sensor_frame;
  const auto base = std::find_if(above.begin(), above.end(), isBaseName);
  if (base != above.end() || isBaseName(sensor_frame)) {
    return base != above.end() ? *base : sensor_frame;
  }
  std::string frame = sensor_frame;
  for (const std::string& parent : above) {
    if (!edges_.at(frame).rigid) break;
    frame = parent;
  }
  return frame;
}

std::string BagTransforms::listFrames() const {
  std::set<std::string> frames;
  for (const auto& [child, edge] : edges_) frames.insert({child, edge.parent});
  std::string text;
  for (const std::string& frame : frames) text += (text.empty() ? "" : ", ") + frame;
  return text.empty() ? "none" : text;
}

std::string BagTransforms::localizationOf(const std::string& frame) const {
  std::string child = frame;
  for (const std::string& parent : ancestors(frame)) {
    if (lastPart(parent) == "map") return parent + " -> " + child;
    child = parent;
  }
  return "";
}

bool BagTransforms::rigid(const std::string& a, const std::string& b) const {
  std::vector<std::string> up_a = ancestors(a), up_b = ancestors(b);
  up_a.insert(up_a.begin(), a);
  up_b.insert(up_b.begin(), b);
  const auto climbRigidly = [&](const std::vector<std::string>& from,
                                const std::vector<std::string>& to) {
    for (const std::string& frame : from) {
      if (std::find(to.begin(), to.end(), frame) != to.end()) return true;
      const auto edge = edges_.find(frame);
      if (edge == edges_.end() || !edge->second.rigid) return false;
    }
    return false;
  };
  return climbRigidly(up_a, up_b) && climbRigidly(up_b, up_a);
}

std::optional<Eigen::Isometry3d> BagTransforms::lookup(const std::string& target,
                                                       const std::string& source,
                                                       const ros::Time& time) const {
  if (target == source) return Eigen::Isometry3d::Identity();
  try {
    const ros::Time when = rigid(target, source) ? ros::Time() : time;
    return fromMessage(buffer_.lookupTransform(target, source, when).transform);
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

bool BagTransforms::connected(const std::string& a, const std::string& b) const {
  std::vector<std::string> up_a = ancestors(a), up_b = ancestors(b);
  const std::string& root_a = up_a.empty() ? a : up_a.back();
  const std::string& root_b = up_b.empty() ? b : up_b.back();
  return root_a == root_b;
}

}  // namespace kestrel
