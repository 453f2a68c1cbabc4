// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace kestrel {

/// The assignment of rows to columns with the smallest sum of costs (Hungarian method, O(n³)): for
/// each row its column, or -1 for a row that is left over because there are fewer columns. All
/// costs must be finite.
std::vector<int> cheapestAssignment(const Eigen::MatrixXd& costs);

}  // namespace kestrel
