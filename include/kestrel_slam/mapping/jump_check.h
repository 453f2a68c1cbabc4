// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/mapping/prediction_error.h"

namespace kestrel {

/// Decides whether a match far from the prediction is taken. A wrong pose of a scan with few points
/// changes from scan to scan. If the prediction is wrong, all scans agree.
class JumpCheck {
 public:
  /// Whether `found` is farther from `predicted` than its error explains.
  static bool isJump(const Pose2& predicted, const Pose2& found, const PredictionError& error);

  /// `error`: of the prediction. A jump is taken if the scans before agree with it.
  bool accepts(const Pose2& predicted, const Pose2& found, const PredictionError& error);

 private:
  Pose2 jump_;        ///< of the last scan that jumped, in the base frame of the prediction
  int agreeing_ = 0;  ///< scans in a row that jumped like this
};

}  // namespace kestrel
