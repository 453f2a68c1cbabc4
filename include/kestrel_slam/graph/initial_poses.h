// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/graph/pose_graph.h"

namespace kestrel {

/// Places the vertices of each connected part along its edges, odometry before loops, from the
/// first fixed vertex, or from the first one, which stays. Fixed vertices stay.
void placeAlongEdges(PoseGraph& graph);

/// Places the vertices without an initial guess: first the yaws, by linear least squares with the
/// rotations as unconstrained complex numbers, then the positions, by linear least squares with
/// these yaws [Carlone 2015, sec. IV-D]. Good enough to start the optimizer near the optimum where
/// odometry has drifted by several turns. It has no robust kernel: use it on a graph without false
/// loops. The vertices of heldVertices() stay. False if the graph has an error or no unique
/// solution; it is not changed then.
bool placeByRotations(PoseGraph& graph);

}  // namespace kestrel
