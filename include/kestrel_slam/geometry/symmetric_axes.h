// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace kestrel {

/// The axes of a symmetric matrix, such as a covariance. Eigen's solver is compiled once behind
/// them, because every file that uses it takes seconds longer to compile.
template <int Size>
struct SymmetricAxes {
  Eigen::Matrix<double, Size, 1> eigenvalues;      ///< smallest first
  Eigen::Matrix<double, Size, Size> eigenvectors;  ///< columns in the same order, of length 1
};

/// Reads the lower triangle.
SymmetricAxes<2> symmetricAxes(const Eigen::Matrix2d& matrix);
SymmetricAxes<3> symmetricAxes(const Eigen::Matrix3d& matrix);

}  // namespace kestrel
