// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/graph/submap_graph.h"
#include "kestrel_slam/session/session.h"

namespace kestrel {

/// The session of a graph, without parameters, statistics, end and writer. The frame of a submap is
/// the local frame of the mapper at the first keyframe of that submap.
Session sessionOf(const GraphRecord& record, double resolution_m);

/// The graph that a session was made of: sessionOf() of it gives the same session. Throws
/// std::runtime_error if the session is not of this kind, or if its cells are not of this size.
GraphRecord graphRecordOf(const Session& session, double resolution_m);

/// Where a flight begins that starts where the last one of the session ended. It may have been
/// moved a little. Nothing if the session is empty.
std::optional<GaussianPose2> startAtEnd(const Session& session);

/// A start that a person gives, with the errors that this has.
GaussianPose2 givenStart(const Pose2& map_T_base);

/// Adds `value` to the statistic with this name.
void addStatistic(Session& session, const std::string& name, double value);

}  // namespace kestrel
