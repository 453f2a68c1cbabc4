// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/geometry/symmetric_axes.h"

#include <Eigen/Eigenvalues>

namespace kestrel {
namespace {

template <int Size>
SymmetricAxes<Size> axesOf(const Eigen::Matrix<double, Size, Size>& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, Size, Size>> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace

SymmetricAxes<2> symmetricAxes(const Eigen::Matrix2d& matrix) { return axesOf<2>(matrix); }
SymmetricAxes<3> symmetricAxes(const Eigen::Matrix3d& matrix) { return axesOf<3>(matrix); }

}  // namespace kestrel
