// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "kestrel_slam/TrackArray.h"

namespace kestrel {

/// What a scan or a cloud shows of what moves, in the frame of the tracks.
struct Followed {
  bool used = false;       ///< false: nothing has changed, and `problem` says why
  bool saturated = false;  ///< there was more than the tracker handles
  std::string problem;     ///< why it is not used, or what limits its use
  std::string note;        ///< about the messages of this source; it is no reason to worry
  kestrel_slam::TrackArray tracks;
  std::vector<Eigen::Vector3f> moving_points;
};

/// A clock that went back by more than this starts the tracker anew, as when a bag is played again,
/// s.
constexpr double kClockWentBack = 1.0;

}  // namespace kestrel
