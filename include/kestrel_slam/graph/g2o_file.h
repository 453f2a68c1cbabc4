// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kestrel_slam/graph/pose_graph.h"

namespace kestrel {

/// A graph with the names that a g2o file gives the vertices.
struct G2oGraph {
  PoseGraph graph;
  std::vector<std::int64_t> ids;  ///< of each vertex; may be empty when written: 0, 1, 2, ...
};

/// Reads the text of a planar graph in the format of g2o [Kümmerle 2011]:
///
///     VERTEX_SE2 id x y yaw
///     EDGE_SE2 from to x y yaw I11 I12 I13 I22 I23 I33
///     FIX id ...
///
/// in any order, with empty lines and comments (#). The vertices are sorted by id. The first edge
/// between a vertex and the next one is odometry; all others are loops. If there is no VERTEX_SE2
/// at all, the vertices are those that the edges name, and placeAlongEdges() places them. Throws
/// std::runtime_error that names `name`, the line and the cause.
G2oGraph parseG2o(const std::string& text, const std::string& name);

/// The same of a file. Throws std::runtime_error.
G2oGraph readG2o(const std::string& path);

/// The text of such a file. Reading it gives the same numbers, bit for bit. The kinds of the edges
/// are not written.
std::string g2oText(const G2oGraph& graph);

/// Replaces the file in one step. Throws std::runtime_error.
void writeG2o(const std::string& path, const G2oGraph& graph);

}  // namespace kestrel
