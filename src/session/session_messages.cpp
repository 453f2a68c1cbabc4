// SPDX-License-Identifier: BSD-3-Clause
#include "session_messages.h"

#include <stdexcept>

namespace kestrel {
namespace {

using Numbers = google::protobuf::RepeatedField<double>;
using NamedNumbers = google::protobuf::RepeatedPtrField<session_format::NamedNumber>;
using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

void setPose(const Pose2& pose, session_format::Pose& message) {
  message.set_x(pose.x);
  message.set_y(pose.y);
  message.set_yaw(pose.yaw);
}

/// Member by member, because the constructor of Pose2 may change the last bit of the yaw.
Pose2 poseOf(const session_format::Pose& message) {
  Pose2 pose;
  pose.x = message.x();
  pose.y = message.y();
  pose.yaw = message.yaw();
  return pose;
}

void setMatrix(const Eigen::Matrix3d& matrix, Numbers& numbers) {
  const Matrix rows = matrix;
  numbers.Add(rows.data(), rows.data() + rows.size());
}

Eigen::Matrix3d matrixOf(const Numbers& numbers) {
  if (numbers.size() != Matrix::SizeAtCompileTime) {
    throw std::runtime_error("a matrix has " + std::to_string(numbers.size()) +
                             " numbers instead of 9");
  }
  return Eigen::Map<const Matrix>(numbers.data());
}

void setNumbers(const std::vector<NamedNumber>& numbers, NamedNumbers& messages) {
  for (const NamedNumber& number : numbers) {
    session_format::NamedNumber* const message = messages.Add();
    message->set_name(number.name);
    message->set_value(number.value);
  }
}

std::vector<NamedNumber> numbersOf(const NamedNumbers& messages) {
  std::vector<NamedNumber> numbers;
  for (const auto& message : messages) numbers.push_back({message.name(), message.value()});
  return numbers;
}

/// Files of this schema version have only values that this version knows.
template <typename Enum>
Enum enumOf(int value, Enum last) {
  if (value < 0 || value > static_cast<int>(last)) {
    throw std::runtime_error("a kind or state has the unknown value " + std::to_string(value));
  }
  return static_cast<Enum>(value);
}

}  // namespace

void setMessage(const KeyframePtr& keyframe, session_format::Keyframe& message) {
  message.set_id(keyframe->id);
  message.set_stamp(keyframe->stamp);
  message.set_time(keyframe->time);
  setPose(keyframe->submap_T_base, *message.mutable_submap_t_base());
  setMatrix(keyframe->covariance, *message.mutable_covariance());
  setMatrix(keyframe->motion_covariance, *message.mutable_motion_covariance());
  message.set_new_view(keyframe->new_view);
  message.set_scan(keyframe->scan.bytes());
  message.set_height_m(keyframe->height.base_m);
  message.set_height_slope_x(keyframe->height.slope.x());
  message.set_height_slope_y(keyframe->height.slope.y());
}

KeyframePtr fromMessage(const session_format::Keyframe& message) {
  auto keyframe = std::make_shared<Keyframe>();
  keyframe->id = message.id();
  keyframe->stamp = message.stamp();
  keyframe->time = message.time();
  keyframe->submap_T_base = poseOf(message.submap_t_base());
  keyframe->covariance = matrixOf(message.covariance());
  keyframe->motion_covariance = matrixOf(message.motion_covariance());
  keyframe->new_view = message.new_view();
  keyframe->height.base_m = message.height_m();
  keyframe->height.slope = {message.height_slope_x(), message.height_slope_y()};
  try {
    keyframe->scan = CompactScan::fromBytes(message.scan());
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error("the scan of keyframe " + std::to_string(message.id()) +
                             " cannot be decoded: " + error.what());
  }
  return keyframe;
}

void setMessage(const SubmapRecord& submap, session_format::Submap& message) {
  message.set_id(submap.id);
  setPose(submap.map_T_submap, *message.mutable_map_t_submap());
  message.set_finished(submap.finished);
  for (const std::uint64_t id : submap.keyframes) message.add_keyframes(id);
}

SubmapRecord fromMessage(const session_format::Submap& message) {
  return {message.id(),
          poseOf(message.map_t_submap()),
          message.finished(),
          {message.keyframes().begin(), message.keyframes().end()}};
}

void setMessage(const VertexRecord& vertex, session_format::Vertex& message) {
  message.set_kind(static_cast<session_format::Vertex::Kind>(vertex.kind));
  message.set_id(vertex.id);
  setPose(vertex.vertex.pose, *message.mutable_map_t_vertex());
  message.set_fixed(vertex.vertex.fixed);
}

VertexRecord fromMessage(const session_format::Vertex& message) {
  return {enumOf(message.kind(), VertexKind::kSubmap),
          message.id(),
          {poseOf(message.map_t_vertex()), message.fixed()}};
}

void setMessage(const PoseEdge& edge, session_format::Edge& message) {
  message.set_from(edge.from);
  message.set_to(edge.to);
  setPose(edge.measured, *message.mutable_measured());
  setMatrix(edge.information, *message.mutable_information());
  message.set_kind(static_cast<session_format::Edge::Kind>(edge.kind));
}

PoseEdge fromMessage(const session_format::Edge& message) {
  return {message.from(), message.to(), poseOf(message.measured()), matrixOf(message.information()),
          enumOf(message.kind(), EdgeKind::kLoop)};
}

void setMessage(const LoopRecord& loop, session_format::Loop& message) {
  message.set_from(loop.from);
  message.set_to(loop.to);
  setPose(loop.measured.mean, *message.mutable_measured());
  setMatrix(loop.measured.covariance, *message.mutable_covariance());
  message.set_state(static_cast<session_format::Loop::State>(loop.state));
  message.set_reason(loop.reason);
  setNumbers(loop.measures, *message.mutable_measures());
}

LoopRecord fromMessage(const session_format::Loop& message) {
  LoopRecord loop;
  loop.from = message.from();
  loop.to = message.to();
  loop.measured = {poseOf(message.measured()), matrixOf(message.covariance())};
  loop.state = enumOf(message.state(), LoopState::kUndone);
  loop.reason = message.reason();
  loop.measures = numbersOf(message.measures());
  return loop;
}

void setMessage(const OdometryRecord& odometry, session_format::Odometry& message) {
  message.set_keyframe(odometry.keyframe);
  for (const Pose2& pose : odometry.odom_T_base) setPose(pose, *message.add_odom_t_base());
  message.set_own(odometry.own);
}

OdometryRecord fromMessage(const session_format::Odometry& message) {
  OdometryRecord odometry{message.keyframe(), {}, message.own()};
  for (const auto& pose : message.odom_t_base()) odometry.odom_T_base.push_back(poseOf(pose));
  return odometry;
}

session_format::Info infoMessage(const Session& session) {
  session_format::Info message;
  message.set_resolution_m(session.resolution_m);
  message.set_parameters(session.parameters);
  setNumbers(session.statistics, *message.mutable_statistics());
  if (session.end) setPose(*session.end, *message.mutable_end());
  message.set_keyframes(session.keyframes.size());
  message.set_submaps(session.submaps.size());
  return message;
}

void takeInfo(const session_format::Info& message, Session& session) {
  session.resolution_m = message.resolution_m();
  session.parameters = message.parameters();
  session.statistics = numbersOf(message.statistics());
  if (message.has_end()) session.end = poseOf(message.end());
}

}  // namespace kestrel
