// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/tracking/mixture_reduction.h"

namespace kestrel {

/// A target in the plane: position ± 0.2 m, velocity ± 1 m/s.
inline PhdComponent<4> componentAt(double x, double y, double vx, double vy, double weight = 1.0) {
  PhdComponent<4> component;
  component.weight = weight;
  component.mean << x, y, vx, vy;
  component.covariance.diagonal() << 0.04, 0.04, 1.0, 1.0;
  return component;
}

}  // namespace kestrel
