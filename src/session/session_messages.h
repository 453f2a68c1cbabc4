// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <session.pb.h>

#include "kestrel_slam/session/session.h"

namespace kestrel {

// Conversion between the parts of a session and the messages of a session file. What has a message
// of a wrong shape throws std::runtime_error. problemOf() checks the rest.

void setMessage(const KeyframePtr& keyframe, session_format::Keyframe& message);
void setMessage(const SubmapRecord& submap, session_format::Submap& message);
void setMessage(const VertexRecord& vertex, session_format::Vertex& message);
void setMessage(const PoseEdge& edge, session_format::Edge& message);
void setMessage(const LoopRecord& loop, session_format::Loop& message);
void setMessage(const OdometryRecord& odometry, session_format::Odometry& message);
/// What is not in lists of its own.
session_format::Info infoMessage(const Session& session);

KeyframePtr fromMessage(const session_format::Keyframe& message);
SubmapRecord fromMessage(const session_format::Submap& message);
VertexRecord fromMessage(const session_format::Vertex& message);
PoseEdge fromMessage(const session_format::Edge& message);
LoopRecord fromMessage(const session_format::Loop& message);
OdometryRecord fromMessage(const session_format::Odometry& message);
void takeInfo(const session_format::Info& message, Session& session);

}  // namespace kestrel
